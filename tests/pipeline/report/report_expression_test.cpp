#include "pipeline/report/report_expression.h"

#include "pipeline/report/report_text.h"
#include "slim/base/error.h"
#include "tests/pipeline/report/report_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace slim::test {
namespace {

double number(const std::string& text) { return formula(text).number(lookup); }

TEST(ReportExpression, ComputesAsWritten) {
    EXPECT_DOUBLE_EQ(number("1 + 2*x^2 - 4/2"), 17);
    EXPECT_DOUBLE_EQ(number("-x^2"), -9);
    EXPECT_DOUBLE_EQ(number("2^-1"), 0.5);
    EXPECT_DOUBLE_EQ(number("2^3^2"), 512);
    EXPECT_DOUBLE_EQ(number("1e-3*m.l2"), 5e-4);
    EXPECT_DOUBLE_EQ(number("max(sqrt(16), abs(-5)) - min(1, 2)"), 4);
    EXPECT_DOUBLE_EQ(number("(1 - 2) - 3"), -4);
    EXPECT_DOUBLE_EQ(number("8/4/2"), 1);
}

TEST(ReportExpression, ComparesNumbersAndTexts) {
    EXPECT_EQ(number("x > 2 && m.l2 <= 0.5"), 1);
    EXPECT_EQ(number("x < 2 || !(x == 3)"), 0);
    EXPECT_EQ(number("shape == 'torus'"), 1);
    EXPECT_EQ(number("shape != \"torus\" || x != 3"), 0);
    EXPECT_EQ(number("shape == 3"), 0);
    EXPECT_EQ(formula("if(shape == 'torus', 'yes', 'no')").evaluate(lookup).text, "yes");
}

TEST(ReportExpression, NamesWhatIsMissingOnlyWhereItIsNeeded) {
    EXPECT_THROW(number("x + m.none"), MissingFigure);
    EXPECT_THROW(number("m.none"), MissingFigure);
    EXPECT_EQ(number("if(x == 3, 1, m.none)"), 1);
    EXPECT_THROW(number("if(x == 3, m.none, 1)"), MissingFigure);
    EXPECT_EQ(number("x == 3 || m.none == 1"), 1);
    EXPECT_EQ(number("m.none == 1 && x == 2"), 0);
    EXPECT_THROW(number("x == 2 || m.none == 1"), MissingFigure);
    EXPECT_THROW(number("shape + 1"), ConfigError);
    EXPECT_THROW(number("shape"), ConfigError);
}

TEST(ReportExpression, RefusesWhatIsNoFormulaWithItsPlace) {
    for (const char* text :
         {"", "1 +", "(1", "1 2", "frob(1)", "'open", "min(1)", "1..2", "x y", "=1"}) {
        try {
            Expression(text, "file.toml:7");
            FAIL() << text;
        } catch (const ConfigError& error) {
            EXPECT_NE(std::string(error.what()).find("file.toml:7"), std::string::npos)
                << error.what();
        }
    }
}

TEST(ReportExpression, FillsBraces) {
    EXPECT_EQ(filled("{x} {m.l2*2} {shape} {{x}}", lookup, 17, ""), "3 1 torus {x}");
    EXPECT_EQ(filled("{1/3}", lookup, 3, ""), "0.333");
    EXPECT_THROW(filled("{x", lookup, 3, ""), ConfigError);
    const double third = std::stod(filled("{1/3}", lookup, 17, ""));
    EXPECT_EQ(third, 1.0 / 3);
}

}  // namespace
}  // namespace slim::test
