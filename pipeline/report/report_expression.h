#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace slim {

/// A number or a text; a truth value is 1 or 0.
struct FigureValue {
    double number = 0;
    std::string text;
    bool is_text = false;
    bool is_missing = false;  ///< `text` is the name: within an evaluation only

    FigureValue(double value = 0) : number(value) {}  // NOLINT: a number is a value
    FigureValue(std::string value) : text(std::move(value)), is_text(true) {}  // NOLINT
};

/// A name that an expression needs and that has no value (yet, or in this row).
struct MissingFigure {
    std::string name;
};

/// A formula of a report file: numbers, 'texts', names (a-z, digits, _ and dots inside: m.l2),
/// + - * / ^, comparisons < <= > >= == !=, and && ||, not !, parentheses, and the functions
/// abs sqrt exp log log10 sin cos floor round finite (one argument), min max (two),
/// if(condition, then, else). Parsed once, evaluated often.
class Expression {
public:
    using Lookup = std::function<FigureValue(const std::string& name)>;

    Expression() = default;
    /// `where` ("quick.toml:12: y") begins the message of the ConfigError for text that is no
    /// formula.
    Expression(const std::string& text, const std::string& where);

    bool empty() const { return code_.empty(); }
    const std::string& text() const { return text_; }
    /// The names in it, in order of appearance, each once.
    const std::vector<std::string>& names() const { return names_; }

    /// throws MissingFigure, from the lookup, unless the value does not matter: in the branch of an
    ///        if that is not taken, beside a false in && or a true in ||; ConfigError where a text
    ///        stands for a number
    FigureValue evaluate(const Lookup& lookup) const;
    double number(const Lookup& lookup) const;
    bool holds(const Lookup& lookup) const { return number(lookup) != 0; }
    /// The same for many rows of numbers: values[i] is that of names()[i]. No text may be in it.
    double number(const std::vector<double>& values) const;

private:
    friend class ExpressionParser;
    enum class Op : unsigned char {
        constant, text, name, add, subtract, multiply, divide, power, negate, less, less_equal,
        greater, greater_equal, equal, unequal, both, either, opposite, choose, least, greatest,
        function
    };
    struct Step {
        Op op;
        double value = 0;       ///< of a constant
        std::size_t index = 0;  ///< of a name, a text or a function
    };
    static std::size_t arity(Op op);
    FigureValue value_of(const Step& step, const Lookup& lookup) const;
    FigureValue combined(const Step& step, const std::vector<FigureValue>& taken) const;
    static double apply(const Step& step, const double* arguments);

    std::string text_, where_;
    std::vector<Step> code_;  ///< postfix
    std::vector<std::string> names_, texts_;
};

}  // namespace slim
