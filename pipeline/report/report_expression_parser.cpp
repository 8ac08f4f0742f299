#include "pipeline/report/report_expression_parser.h"

#include "pipeline/report/report_functions.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <utility>

namespace slim {

void ExpressionParser::parse() {
    either();
    skip();
    if (at_ < text_.size()) fail("the end");
}

void ExpressionParser::fail(const std::string& expected) const {
    throw ConfigError(fmt::format("{}: '{}': expected {}, found '{}'", out_.where_, text_,
                                  expected, text_.substr(at_)));
}

void ExpressionParser::skip() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
}

bool ExpressionParser::take(std::string_view word) {
    skip();
    if (std::string_view(text_).substr(at_, word.size()) != word) return false;
    at_ += word.size();
    return true;
}

void ExpressionParser::need(std::string_view word) {
    if (!take(word)) fail(fmt::format("'{}'", word));
}

void ExpressionParser::add(Op op, double value, std::size_t index) {
    out_.code_.push_back({op, value, index});
}

void ExpressionParser::either() {
    both();
    while (take("||")) both(), add(Op::either);
}

void ExpressionParser::both() {
    comparison();
    while (take("&&")) comparison(), add(Op::both);
}

void ExpressionParser::comparison() {
    sum();
    static constexpr std::array<std::pair<const char*, Op>, 6> kSigns{
        {{"<=", Op::less_equal},
         {">=", Op::greater_equal},
         {"==", Op::equal},
         {"!=", Op::unequal},
         {"<", Op::less},
         {">", Op::greater}}};
    for (const auto& [sign, op] : kSigns)
        if (take(sign)) {
            sum();
            add(op);
            return;
        }
}

void ExpressionParser::sum() {
    product();
    for (;;) {
        if (take("+"))
            product(), add(Op::add);
        else if (take("-"))
            product(), add(Op::subtract);
        else
            return;
    }
}

void ExpressionParser::product() {
    signed_power();
    for (;;) {
        if (take("*"))
            signed_power(), add(Op::multiply);
        else if (take("/"))
            signed_power(), add(Op::divide);
        else
            return;
    }
}

void ExpressionParser::signed_power() {
    if (take("-")) {
        signed_power();
        add(Op::negate);
    } else if (!std::string_view(text_).substr(at_).starts_with("!=") && take("!")) {
        signed_power();
        add(Op::opposite);
    } else {
        primary();
        if (take("^")) signed_power(), add(Op::power);
    }
}

void ExpressionParser::primary() {
    skip();
    const char c = at_ < text_.size() ? text_[at_] : '\0';
    if (take("(")) {
        either();
        need(")");
    } else if (c == '\'' || c == '"') {
        literal(c);
    } else if (std::isdigit(static_cast<unsigned char>(c)) || c == '.') {
        constant();
    } else if (std::isalpha(static_cast<unsigned char>(c)) || c == '_') {
        word();
    } else {
        fail("a number, a name or '('");
    }
}

void ExpressionParser::literal(char quote) {
    const std::size_t end = text_.find(quote, at_ + 1);
    if (end == std::string::npos) fail("a closing quote");
    out_.texts_.push_back(text_.substr(at_ + 1, end - at_ - 1));
    add(Op::text, 0, out_.texts_.size() - 1);
    at_ = end + 1;
}

void ExpressionParser::constant() {
    double value = 0;
    const auto [end, error] =
        std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
    if (error != std::errc{}) fail("a number");
    at_ = static_cast<std::size_t>(end - text_.data());
    add(Op::constant, value);
}

void ExpressionParser::word() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && (std::isalnum(static_cast<unsigned char>(text_[at_])) ||
                                  text_[at_] == '_' || text_[at_] == '.'))
        ++at_;
    const std::string name = text_.substr(begin, at_ - begin);
    if (take("("))
        call(name);
    else
        add(Op::name, 0, index_of(name));
}

std::size_t ExpressionParser::index_of(const std::string& name) {
    const auto found = std::find(out_.names_.begin(), out_.names_.end(), name);
    const auto index = static_cast<std::size_t>(found - out_.names_.begin());
    if (found == out_.names_.end()) out_.names_.push_back(name);
    return index;
}

void ExpressionParser::call(const std::string& name) {
    either();
    if (name == "if") {
        need(","), either(), need(","), either(), need(")");
        return add(Op::choose);
    }
    if (name == "min" || name == "max") {
        need(","), either(), need(")");
        return add(name == "min" ? Op::least : Op::greatest);
    }
    need(")");
    for (std::size_t i = 0; i < kReportFunctions.size(); ++i)
        if (name == kReportFunctions[i].name) return add(Op::function, 0, i);
    fail("a known function instead of '" + name + "'");
}

}  // namespace slim
