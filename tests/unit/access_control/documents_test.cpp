// The cache of documents that were read before: what it keeps, for which participants, and how
// much.
#include "plugins/access_control/documents.hpp"

#include "tests/unit/access_control/access_control_fixture.hpp"

namespace ddssec::access_control {
namespace {

class Cache : public AccessControlTest {
 protected:
  std::shared_ptr<const PermissionsCa> ca() const {
    auto loaded = PermissionsCa::load("data:," + authorities().permissions_ca.certificate().pem());
    EXPECT_TRUE(loaded);
    return *loaded;
  }
};

TEST_F(Cache, ADocument_IsReadOnce) {
  DocumentCache cache(governance::PartitionMatch::all, 4, 1 << 20);
  const auto document = open_permissions(kTalker);
  const auto first = cache.permissions(*ca(), as_bytes(document), kNow);
  const auto second = cache.permissions(*ca(), as_bytes(document), kNow);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(*first, *second) << "the same object: it was read once";
}

TEST_F(Cache, ATextThatIsSignedAgain_IsAnotherDocument) {
  DocumentCache cache(governance::PartitionMatch::all, 4, 1 << 20);
  const auto first = cache.permissions(*ca(), as_bytes(open_permissions(kTalker)), kNow);
  const auto same = cache.permissions(*ca(), as_bytes(open_permissions(kTalker)), kNow);
  signing_time += 1s;
  const auto later = cache.permissions(*ca(), as_bytes(open_permissions(kTalker)), kNow);
  ASSERT_TRUE(first && same && later);
  EXPECT_EQ(*first, *same);
  EXPECT_EQ((*first)->signing_time(), kNow);
  EXPECT_EQ((*later)->signing_time(), kNow + 1s);
  EXPECT_EQ(cache.size(), 2u);
}

TEST_F(Cache, OnlyVerifiedDocuments_GetIn) {
  DocumentCache cache(governance::PartitionMatch::all, 4, 1 << 20);
  const auto forged = signed_by(authorities().other_ca, "<dds/>");
  EXPECT_CODE(cache.permissions(*ca(), as_bytes(forged), kNow), smime_signer_not_permissions_ca);
  EXPECT_EQ(cache.size(), 0u);
}

TEST_F(Cache, AnotherCa_JudgesAnew) {
  DocumentCache cache(governance::PartitionMatch::all, 4, 1 << 20);
  const auto document = open_permissions(kTalker);
  ASSERT_TRUE(cache.permissions(*ca(), as_bytes(document), kNow));
  const auto other = PermissionsCa::load("data:," + authorities().other_ca.certificate().pem());
  ASSERT_TRUE(other);
  EXPECT_CODE(cache.permissions(**other, as_bytes(document), kNow),
              smime_signer_not_permissions_ca);
}

TEST_F(Cache, TooManyDocumentsOrOctets_AreDropped) {
  DocumentCache few(governance::PartitionMatch::all, 2, 1 << 20);
  const std::vector<std::string> documents = {open_permissions("CN=a"), open_permissions("CN=b"),
                                              open_permissions("CN=c")};
  const auto first = few.permissions(*ca(), as_bytes(documents[0]), kNow);
  ASSERT_TRUE(first);
  for (const auto& document : documents) {
    ASSERT_TRUE(few.permissions(*ca(), as_bytes(document), kNow));
    const auto again = few.permissions(*ca(), as_bytes(documents[0]), kNow);
    ASSERT_TRUE(again);
    EXPECT_EQ(*again, *first) << "used in between, so it stays";
  }
  EXPECT_EQ(few.size(), 2u);
  DocumentCache small(governance::PartitionMatch::all, 100, documents[0].size() + 10);
  for (const auto& document : documents) {
    ASSERT_TRUE(small.permissions(*ca(), as_bytes(document), kNow));
  }
  EXPECT_EQ(small.size(), 1u);
}

// A peer can send its document with other blank lines each time.
TEST_F(Cache, FormsOfOneText_ShareAPlace) {
  DocumentCache cache(governance::PartitionMatch::all, 4, 1 << 20);
  const auto document = open_permissions(kTalker);
  const auto first = cache.permissions(*ca(), as_bytes(document), kNow);
  ASSERT_TRUE(first);
  for (int round = 0; round < 2; ++round) {
    for (std::size_t i = 1; i < 20; ++i) {
      const auto again = cache.permissions(*ca(), as_bytes(document + std::string(i, '\n')), kNow);
      ASSERT_TRUE(again);
      EXPECT_EQ(*again, *first);
    }
  }
  EXPECT_EQ(cache.size(), 1u);
}

TEST_F(Cache, FormsOfADroppedText_AreDroppedWithIt) {
  DocumentCache one(governance::PartitionMatch::all, 1, 1 << 20);
  const auto document = open_permissions(kTalker);
  const auto read = [&](const std::string& text) {
    const auto found = one.permissions(*ca(), as_bytes(text), kNow);
    EXPECT_TRUE(found);
    return found.value_or(nullptr);
  };
  const auto first = read(document);
  EXPECT_EQ(read(document + "\n"), first);
  EXPECT_NE(read(open_permissions("CN=a")), first);
  const auto again = read(document + "\n");
  EXPECT_NE(again, first) << "read anew";
  EXPECT_EQ(read(document), again);
  EXPECT_EQ(one.size(), 1u);
}

TEST_F(Cache, AnExpiredCa_IsSeenInTheCacheToo) {
  DocumentCache cache(governance::PartitionMatch::all, 4, 1 << 20);
  const auto document = open_permissions(kTalker);
  ASSERT_TRUE(cache.permissions(*ca(), as_bytes(document), kNow));
  EXPECT_CODE(cache.permissions(*ca(), as_bytes(document), kNow + 400 * 24h), certificate_expired);
}

TEST_F(Cache, ManySubjectsOfOneDocument_AreCompiledWithinBounds) {
  std::vector<governance::Grant> grants;
  for (int i = 0; i < 200; ++i) {
    grants.push_back(grant("CN=p" + std::to_string(i), {publish_rule(true, {"t"})}));
  }
  DocumentCache cache(governance::PartitionMatch::all, 4, 1 << 20);
  const auto document =
      cache.permissions(*ca(), as_bytes(signed_permissions(std::move(grants))), kNow);
  ASSERT_TRUE(document) << document.error().to_sentence();
  for (int i = 0; i < 200; ++i) {
    const auto text = "CN=p" + std::to_string(i);
    EXPECT_TRUE((*document)->grant_for(*pki::SubjectName::parse(text), text, 0, "", kNow));
  }
}

}  // namespace
}  // namespace ddssec::access_control
