// The typed result of a command, and the command as the table contains it.
#pragma once

#include <functional>
#include <string>
#include <utility>

#include "cli/frame/fields.hpp"
#include "cli/frame/fields_json.hpp"
#include "cli/frame/fields_members.hpp"
#include "cli/frame/fields_schema.hpp"
#include "cli/frame/report.hpp"

namespace ddssec::cli {

class Arguments;
struct Context;

/// The return value of a command whose result has the type T.
template <class T>
struct Answer {
  T result;
  /// Everything besides the result. Its text follows that of the result and contains no facts, only
  /// what to do next. Its `result` stays empty.
  Report report = {};
  /// False: the answer is no, and the report says why. The JSON's result is {}.
  bool has_result = true;
};

/// Returns the lines of a result, from its member text(). They are made from the values in the
/// JSON, and from members that are no fields.
template <class T>
std::string text_of(const T& result) {
  if constexpr (fields_detail::kIsA<T, std::variant>)
    return std::visit([](const auto& held) { return held.text(); }, result);
  else
    return result.text();
}

/// Returns the report of an answer. Its text and its JSON are both made from the result.
template <class T>
Report report_of(Answer<T> answer) {
  auto out = std::move(answer.report);
  if (!answer.has_result) return out;
  out.text = text_of(answer.result) + out.text;
  out.result = to_json(answer.result);
  return out;
}

/// The field list of a result, as generated pages need it.
struct ResultShape {
  Json schema;          ///< of `result`
  Json definitions;     ///< entries of the schema's $defs that are made from field lists
  std::string members;  ///< the row of the README's table
  Json rows;            ///< rows for members that have rows of their own
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
  /// Returns the field list of its result.
  ResultShape shape() const { return shape_(); }

 private:
  std::function<Result<Report>(const Arguments&, const Context&)> run_;
  ResultShape (*shape_)();
};

}  // namespace ddssec::cli
