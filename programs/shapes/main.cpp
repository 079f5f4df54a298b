
#include "programs/shapes/session.hpp"

namespace {

using namespace ddssec::shapes;

int run(Session& session) {
  const auto& options = session.options();
  if (options.publish)
    return options.final_type ? run_publisher<FinalShapeType>(session)
                              : run_publisher<ShapeType>(session);
  return options.final_type ? run_subscriber<FinalShapeType>(session)
                            : run_subscriber<ShapeType>(session);
}

}  // namespace

int main(int argc, char** argv) {
  const auto parsed = parse(argc, argv);
  if (!parsed.options) return parsed.exit_code;
  hold_signals();
  Session session(*parsed.options);
  if (const auto opened = session.open(); !opened)
    return not_created("participant", opened.error());
  const int code = run(session);
  if (code == kDone) print_line("Done.");
  return code;
}
