#include "pipeline/report_expression.h"

#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>

namespace slim {
namespace {

struct Function {
    const char* name;
    double (*apply)(double);
};
constexpr std::array<Function, 10> kFunctions{{
    {"abs", [](double x) { return std::abs(x); }},
    {"sqrt", [](double x) { return std::sqrt(x); }},
    {"exp", [](double x) { return std::exp(x); }},
    {"log", [](double x) { return std::log(x); }},
    {"log10", [](double x) { return std::log10(x); }},
    {"sin", [](double x) { return std::sin(x); }},
    {"cos", [](double x) { return std::cos(x); }},
    {"floor", [](double x) { return std::floor(x); }},
    {"round", [](double x) { return std::round(x); }},
    {"finite", [](double x) { return std::isfinite(x) ? 1.0 : 0.0; }},
}};

}  // namespace

/// Recursive descent; every rule appends its postfix code.
class ExpressionParser {
public:
    explicit ExpressionParser(Expression& out) : out_(out), text_(out.text_) {}

    void parse() {
        either();
        skip();
        if (at_ < text_.size()) fail("the end");
    }

private:
    using Op = Expression::Op;

    [[noreturn]] void fail(const std::string& expected) const {
        throw ConfigError(fmt::format("{}: '{}': expected {}, found '{}'", out_.where_, text_,
                                      expected, text_.substr(at_)));
    }
    void skip() {
        while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
    }
    bool take(std::string_view word) {
        skip();
        if (std::string_view(text_).substr(at_, word.size()) != word) return false;
        at_ += word.size();
        return true;
    }
    void need(std::string_view word) {
        if (!take(word)) fail(fmt::format("'{}'", word));
    }
    void add(Op op, double value = 0, std::size_t index = 0) {
        out_.code_.push_back({op, value, index});
    }
    void either() {
        both();
        while (take("||")) both(), add(Op::either);
    }
    void both() {
        comparison();
        while (take("&&")) comparison(), add(Op::both);
    }
    void comparison() {
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
    void sum() {
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
    void product() {
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
    void signed_power() {
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
    void primary() {
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
    void literal(char quote) {
        const std::size_t end = text_.find(quote, at_ + 1);
        if (end == std::string::npos) fail("a closing quote");
        out_.texts_.push_back(text_.substr(at_ + 1, end - at_ - 1));
        add(Op::text, 0, out_.texts_.size() - 1);
        at_ = end + 1;
    }
    void constant() {
        double value = 0;
        const auto [end, error] =
            std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
        if (error != std::errc{}) fail("a number");
        at_ = static_cast<std::size_t>(end - text_.data());
        add(Op::constant, value);
    }
    void word() {
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
    std::size_t index_of(const std::string& name) {
        const auto found = std::find(out_.names_.begin(), out_.names_.end(), name);
        const auto index = static_cast<std::size_t>(found - out_.names_.begin());
        if (found == out_.names_.end()) out_.names_.push_back(name);
        return index;
    }
    void call(const std::string& name) {
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
        for (std::size_t i = 0; i < kFunctions.size(); ++i)
            if (name == kFunctions[i].name) return add(Op::function, 0, i);
        fail("a known function instead of '" + name + "'");
    }

    Expression& out_;
    const std::string& text_;
    std::size_t at_ = 0;
};

Expression::Expression(const std::string& text, const std::string& where)
    : text_(text), where_(where) {
    ExpressionParser(*this).parse();
}

std::size_t Expression::arity(Op op) {
    if (op == Op::negate || op == Op::opposite || op == Op::function) return 1;
    return op == Op::choose ? 3 : 2;
}

double Expression::apply(const Step& step, const double* a) {
    switch (step.op) {
        case Op::add: return a[0] + a[1];
        case Op::subtract: return a[0] - a[1];
        case Op::multiply: return a[0] * a[1];
        case Op::divide: return a[0] / a[1];
        case Op::power: return std::pow(a[0], a[1]);
        case Op::negate: return -a[0];
        case Op::less: return a[0] < a[1] ? 1 : 0;
        case Op::less_equal: return a[0] <= a[1] ? 1 : 0;
        case Op::greater: return a[0] > a[1] ? 1 : 0;
        case Op::greater_equal: return a[0] >= a[1] ? 1 : 0;
        case Op::equal: return a[0] == a[1] ? 1 : 0;
        case Op::unequal: return a[0] != a[1] ? 1 : 0;
        case Op::both: return a[0] != 0 && a[1] != 0 ? 1 : 0;
        case Op::either: return a[0] != 0 || a[1] != 0 ? 1 : 0;
        case Op::opposite: return a[0] == 0 ? 1 : 0;
        case Op::choose: return a[0] != 0 ? a[1] : a[2];
        case Op::least: return std::min(a[0], a[1]);
        case Op::greatest: return std::max(a[0], a[1]);
        case Op::function: return kFunctions[step.index].apply(a[0]);
        default: return std::numeric_limits<double>::quiet_NaN();
    }
}

FigureValue Expression::value_of(const Step& step, const Lookup& lookup) const {
    if (step.op == Op::constant) return step.value;
    if (step.op == Op::text) return texts_[step.index];
    try {
        return lookup(names_[step.index]);
    } catch (const MissingFigure& missing) {
        FigureValue value(missing.name);
        value.is_missing = true;
        return value;
    }
}

FigureValue Expression::combined(const Step& step, const std::vector<FigureValue>& taken) const {
    if (step.op == Op::choose && !taken[0].is_missing)
        return taken[0].number != 0 ? taken[1] : taken[2];
    // One side may settle it without the other.
    const auto settles = [&](const FigureValue& v) {
        return !v.is_missing && !v.is_text && (v.number != 0) == (step.op == Op::either);
    };
    if ((step.op == Op::both || step.op == Op::either) && (settles(taken[0]) || settles(taken[1])))
        return step.op == Op::either ? 1.0 : 0.0;
    for (const FigureValue& value : taken)
        if (value.is_missing) return value;
    const bool compares = step.op == Op::equal || step.op == Op::unequal;
    double numbers[3] = {};
    for (std::size_t i = 0; i < taken.size(); ++i) {
        if (taken[i].is_text && !compares)
            throw ConfigError(fmt::format("{}: '{}': expected a number, found '{}'", where_, text_,
                                          taken[i].text));
        numbers[i] = taken[i].number;
    }
    if (!compares || (!taken[0].is_text && !taken[1].is_text)) return apply(step, numbers);
    const bool same = taken[0].is_text && taken[1].is_text && taken[0].text == taken[1].text;
    return same == (step.op == Op::equal) ? 1.0 : 0.0;
}

FigureValue Expression::evaluate(const Lookup& lookup) const {
    std::vector<FigureValue> stack;
    for (const Step& step : code_) {
        if (step.op == Op::constant || step.op == Op::text || step.op == Op::name) {
            stack.push_back(value_of(step, lookup));
            continue;
        }
        const auto first = stack.end() - static_cast<std::ptrdiff_t>(arity(step.op));
        FigureValue value = combined(step, {first, stack.end()});
        stack.erase(first, stack.end());
        stack.push_back(std::move(value));
    }
    if (stack.back().is_missing) throw MissingFigure{stack.back().text};
    return stack.back();
}

double Expression::number(const Lookup& lookup) const {
    const FigureValue value = evaluate(lookup);
    if (value.is_text)
        throw ConfigError(
            fmt::format("{}: '{}': expected a number, found '{}'", where_, text_, value.text));
    return value.number;
}

double Expression::number(const std::vector<double>& values) const {
    std::array<double, 64> stack;
    std::size_t n = 0;
    for (const Step& step : code_) {
        if (n + 1 >= stack.size())
            throw ConfigError(fmt::format("{}: '{}': nested too deep", where_, text_));
        if (step.op == Op::constant) {
            stack[n++] = step.value;
        } else if (step.op == Op::name) {
            stack[n++] = values[step.index];
        } else if (step.op == Op::text) {
            throw ConfigError(fmt::format("{}: '{}': no texts here", where_, text_));
        } else {
            n -= arity(step.op);
            stack[n] = apply(step, &stack[n]);
            ++n;
        }
    }
    return stack[0];
}

}  // namespace slim
