#include "plugins/access_control/announced.hpp"

#include <gtest/gtest.h>

namespace ddssec::access_control {
namespace {

using Partitions = std::vector<std::string_view>;

TEST(AnnouncedEndpoints, TheNewestStayAndWildcardsMeetNames) {
  AnnouncedEndpoints announced;
  const auto meets = [&](const Partitions& ours) {
    return announced.meeting(Action::publish, {.topic_name = "t", .partitions = ours}).size();
  };
  const Partitions a = {"a"}, star = {"a*"}, other = {"b", ""};
  announced.note(Action::publish, {.topic_name = "t", .partitions = a});
  announced.note(Action::publish, {.topic_name = "t", .partitions = a});
  EXPECT_EQ(meets(a), 1u);
  EXPECT_EQ(meets(star), 1u);
  EXPECT_EQ(meets(other), 0u);
  EXPECT_EQ(meets({}), 0u);
  announced.note(Action::publish, {.topic_name = "t", .partitions = star});
  EXPECT_EQ(meets(star), 2u);
  EXPECT_EQ(meets(Partitions{"?"}), 1u);  // two expressions do not meet unless they are equal
  announced.note(Action::publish, {.topic_name = "t"});
  EXPECT_EQ(meets(other), 1u);
  EXPECT_TRUE(announced.meeting(Action::subscribe, {.topic_name = "t"}).empty());
  EXPECT_TRUE(announced.meeting(Action::publish, {.topic_name = "u"}).empty());
  const std::string large(AnnouncedEndpoints::kMostOctets, 'x');
  announced.note(Action::publish, {.topic_name = large, .partitions = a});
  EXPECT_TRUE(announced.meeting(Action::publish, {.topic_name = large, .partitions = a}).empty());
  for (std::size_t i = 0; i < AnnouncedEndpoints::kMost; ++i)
    announced.note(Action::publish, {.topic_name = std::to_string(i)});
  EXPECT_EQ(meets(star), 0u);
  EXPECT_EQ(announced.meeting(Action::publish, {.topic_name = "0"}).size(), 1u);
}

}  // namespace
}  // namespace ddssec::access_control
