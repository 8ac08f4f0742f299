#pragma once

#include "pipeline/report/report_expression.h"

#include <cstddef>
#include <string>
#include <string_view>

namespace slim {

/// Recursive descent over the text of an expression; every rule appends its postfix code.
class ExpressionParser {
public:
    explicit ExpressionParser(Expression& out) : out_(out), text_(out.text_) {}

    /// throws ConfigError naming the place, for text that is no formula
    void parse();

private:
    using Op = Expression::Op;

    [[noreturn]] void fail(const std::string& expected) const;
    void skip();
    bool take(std::string_view word);
    void need(std::string_view word);
    void add(Op op, double value = 0, std::size_t index = 0);

    // From what binds least to what binds most.
    void either();
    void both();
    void comparison();
    void sum();
    void product();
    void signed_power();
    void primary();

    void literal(char quote);
    void constant();
    void word();
    std::size_t index_of(const std::string& name);
    void call(const std::string& name);

    Expression& out_;
    const std::string& text_;
    std::size_t at_ = 0;
};

}  // namespace slim
