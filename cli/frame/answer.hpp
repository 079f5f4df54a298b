// The typed result of a command, and the command as the table has it.
#pragma once

#include <functional>
#include <string>
#include <utility>

#include "cli/frame/fields.hpp"
#include "cli/frame/report.hpp"

namespace ddssec::cli {

class Arguments;
struct Context;

/// What a command with a result of the type T returns.
template <class T>
struct Answer {
  T result;
  /// Everything else. Its text follows that of the result and has no facts: it says what to do
  /// next. Its `result` stays empty.
  Report report = {};
  bool has_result = true;  ///< false: the answer is no, and says why; the JSON's result is {}
};

/// The lines of a result: those of its member text(). They are made from the values that the JSON
/// has, and from members that are no fields.
template <class T>
std::string text_of(const T& result) {
  if constexpr (fields_detail::kIsA<T, std::variant>)
    return std::visit([](const auto& held) { return held.text(); }, result);
  else
    return result.text();
}

/// The report: both forms are made from the result.
template <class T>
Report report_of(Answer<T> answer) {
  auto out = std::move(answer.report);
  if (!answer.has_result) return out;
  out.text = text_of(answer.result) + out.text;
  out.result = to_json(answer.result);
  return out;
}

/// The field list of a result, as the pages need it.
struct ResultShape {
  Json schema;          ///< of `result`
  Json definitions;     ///< entries of the schema's $defs that are made from field lists
  std::string members;  ///< the row of the README's table
  Json rows;            ///< of members that have rows of their own
};

template <class T>
ResultShape shape_of() {
  Json definitions = Json::object();
  add_definitions<T>(definitions);
  Json rows = Json::object();
  add_rows<T>(rows);
  return {schema_of<T>(), std::move(definitions), members_of<T>(), std::move(rows)};
}

/// The function of a command.
class Runner {
 public:
  template <class T>
  Runner(Result<Answer<T>> (*run)(const Arguments&, const Context&))
      : run_([run](const Arguments& arguments, const Context& context) -> Result<Report> {
          auto answer = run(arguments, context);
          if (!answer) return std::unexpected(std::move(answer.error()));
          return report_of(*std::move(answer));
        }),
        shape_(shape_of<T>) {}

  Result<Report> operator()(const Arguments& arguments, const Context& context) const {
    return run_(arguments, context);
  }
  /// The field list of its result.
  ResultShape shape() const { return shape_(); }

 private:
  std::function<Result<Report>(const Arguments&, const Context&)> run_;
  ResultShape (*shape_)();
};

}  // namespace ddssec::cli
