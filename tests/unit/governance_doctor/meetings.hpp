// Two participants that would meet.
#pragma once

#include <gmock/gmock.h>

#include "doctor_fixture.hpp"
#include "governance/doctor/meeting.hpp"

namespace ddssec::governance::doctor::meetings {

class MeetingTest : public Folders {
 protected:
  MeetingTest() : talker_(participant("talker")), listener_(participant("listener")) {}

  Meeting meeting(const std::vector<std::string>& topics = {}, Product a = Product::ddssec,
                  Product b = Product::ddssec) const {
    const auto first = load_folder(talker_, kNow);
    const auto second = load_folder(listener_, kNow);
    auto out =
        predict_meeting({first, a, "talker"}, {second, b, "listener"}, {.now = kNow}, topics);
    // The rules point into the loaded folders, which end here.
    for (auto& rule : out.rules) rule = nullptr;
    return out;
  }
  std::vector<Rule> findings(const Meeting& meeting) const {
    std::vector<Rule> out;
    for (const auto& finding : meeting.findings) out.push_back(finding.rule);
    return out;
  }

  pki::ParticipantFolder talker_;
  pki::ParticipantFolder listener_;
};

}  // namespace ddssec::governance::doctor::meetings
