#include "pipeline/report_cloud.h"
#include "pipeline/report_file.h"
#include "pipeline/report_page.h"
#include "pipeline/report_results.h"
#include "pipeline/report_row.h"
#include "pipeline/report_text.h"
#include "pipeline/svg_plot.h"
#include "pipeline/report_times.h"
#include "tests/formats/file_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <regex>

namespace slim::test {
namespace {

Expression formula(const std::string& text) { return Expression(text, "test"); }

FigureValue lookup(const std::string& name) {
    if (name == "x") return 3.0;
    if (name == "m.l2") return 0.5;
    if (name == "shape") return std::string("torus");
    throw MissingFigure{name};
}

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
    for (const char* text : {"", "1 +", "(1", "1 2", "frob(1)", "'open", "min(1)", "1..2", "x y", "=1"}) {
        try {
            Expression(text, "file.toml:7");
            FAIL() << text;
        } catch (const ConfigError& error) {
            EXPECT_NE(std::string(error.what()).find("file.toml:7"), std::string::npos) << error.what();
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

Experiment grid_of(const std::vector<double>& points) {
    Experiment e;
    e.grid = {{"degree", {1.0, 2.0}}, {"points", {}}};
    for (const double n : points) e.grid[1].second.emplace_back(n);
    return e;
}

TEST(ReportRows, AreTheProductOfTheGridUpToTheCap) {
    const Experiment e = grid_of({10, 20, 30});
    const auto rows = rows_of(e, {{"points", 5.0}, {"other", 7.0}}, 0);
    ASSERT_EQ(rows.size(), 6u);
    EXPECT_EQ(rows[1].label(e), "degree 1, points 20");
    EXPECT_EQ(rows[5].label(e), "degree 2, points 30");
    EXPECT_EQ(rows[0].at("points").number, 10);  // the grid's, not the file's
    EXPECT_EQ(rows[0].at("other").number, 7);
    EXPECT_EQ(rows_of(e, {}, 20).size(), 4u);
    EXPECT_TRUE(rows_of(e, {}, 5).empty());
    Experiment some = grid_of({10, 20, 30});
    some.when = formula("points <= largest && degree == 2");
    const auto meant = rows_of(some, {{"largest", 20.0}}, 0);
    ASSERT_EQ(meant.size(), 2u);
    EXPECT_EQ(meant[1].label(some), "degree 2, points 20");
}

ReportRow row_with(double x, double y) {
    ReportRow row;
    row.parameters = {{"x", x}};
    StepRecord step;
    step.step = "m", step.done = true,
    step.figures = {{"y", y}, {"deep", {{"list", {1, 2, 5}}}}, {"null", nullptr}};
    row.steps.push_back(step);
    return row;
}

TEST(ReportRows, FindFiguresOfSteps) {
    const ReportRow row = row_with(1, 2);
    EXPECT_EQ(row.at("m.y").number, 2);
    EXPECT_EQ(row.at("m.deep.list.2").number, 5);
    for (const char* none : {"m.z", "m.deep", "m.deep.list.3", "m.null", "q", "m"})
        EXPECT_THROW(row.at(none), MissingFigure) << none;
    EXPECT_EQ(row.text("{m.y} {m.z}", 4, ""), "no figure 'm.z'");
}

Experiment power_law() {
    Experiment e;
    e.name = "law";
    e.grid = {{"x", {1.0, 2.0, 4.0}}};
    ReportPlot plot;
    plot.title = "y", plot.x = formula("x"), plot.y = formula("m.y");
    plot.slopes = true, plot.theory = formula("-1.5"), plot.broken = formula("m.y < 0.2");
    plot.least_slope = formula("-1.6"), plot.most_slope = formula("-1.4");
    e.plots = {plot};
    return e;
}

ExperimentResult judged(const Experiment& e, const std::vector<ReportRow>& rows) {
    ExperimentResult result;
    result.experiment = &e;
    result.rows = rows;
    judge(result);
    return result;
}

std::vector<ReportRow> power_rows(double exponent) {
    std::vector<ReportRow> rows;
    for (const double x : {1.0, 2.0, 4.0}) rows.push_back(row_with(x, std::pow(x, exponent)));
    return rows;
}

TEST(ReportResults, SlopesAndBreakingPointsAreThoseOfTheCurve) {
    const Experiment e = power_law();
    const ExperimentResult result = judged(e, power_rows(-1.5));
    const Curve& curve = result.plots.at(0).curves.at(0);
    EXPECT_NEAR(curve.slope.value(), -1.5, 1e-12);
    EXPECT_EQ(curve.theory.value(), -1.5);
    EXPECT_EQ(curve.breaks.value().x, 4);
    ASSERT_EQ(result.checks.size(), 1u);
    EXPECT_EQ(result.checks[0].verdict, Verdict::passed);
    EXPECT_EQ(judged(e, power_rows(-1.3)).checks.at(0).verdict, Verdict::failed);
}

TEST(ReportResults, ARowWithoutItsFigureIsWhereACurveBreaks) {
    const Experiment e = power_law();
    auto rows = power_rows(-1);
    rows[1].steps[0].done = false, rows[1].steps[0].figures = {{"exit", 3}};
    EXPECT_EQ(judged(e, rows).plots.at(0).curves.at(0).breaks.value().x, 2);
}

TEST(ReportResults, ABandOfASlopeThatCannotBeToldFails) {
    Experiment e = power_law();
    const auto verdict = [&e] {
        const ExperimentResult result = judged(e, power_rows(-1.5));
        return result.checks.empty() ? Verdict::passed : result.checks[0].verdict;
    };
    ASSERT_EQ(verdict(), Verdict::passed);
    e.plots[0].least_slope = formula("m.none"), e.plots[0].most_slope = Expression();
    EXPECT_EQ(verdict(), Verdict::failed);  // no end of the band
    e = power_law();
    e.plots[0].y = formula("m.none"), e.plots[0].broken = Expression();
    EXPECT_EQ(verdict(), Verdict::failed);  // no figure
    e = power_law();
    ReportRow absent = row_with(1, 1);
    absent.steps[0].done = false, absent.steps[0].absent = true, absent.steps[0].figures = {};
    EXPECT_EQ(judged(e, {absent, absent}).checks.at(0).verdict, Verdict::not_run);
    EXPECT_EQ(judged(e, {row_with(1, 1)}).checks.at(0).verdict, Verdict::not_run);  // one row below the cap
}

TEST(ReportResults, ACaseFailsWithAStepThatMayNotBesideOneThatMay) {
    Experiment e;
    e.row = "1", e.pass = formula("m.y == 1");
    ReportStep m, other, may;
    m.name = "m", other.name = "other", may.name = "may", may.may_fail = true;
    e.steps = {m, other, may};
    ReportRow row = row_with(1, 1);
    StepRecord failed;
    failed.step = "may", failed.figures = {{"exit", 3}};
    row.steps.push_back(failed);
    EXPECT_EQ(judged(e, {row}).verdict->verdict, Verdict::passed);
    row.steps.back().step = "other";
    EXPECT_EQ(judged(e, {row}).verdict->verdict, Verdict::failed);
}

TEST(ReportPages, LeaveOutAPictureWhoseConditionLacksItsFigure) {
    Report report;
    report.files.resize(1);
    report.files[0].experiments.resize(1);
    Experiment& e = report.files[0].experiments[0];
    ReportPictures shown;
    shown.of = "m", shown.when = formula("m.none > 1");
    e.pictures = {shown};
    report.results = {{judged(e, {row_with(1, 1)})}};
    std::string page;
    EXPECT_NO_THROW(page = report_page(report));
    EXPECT_NE(page.find("</html>"), std::string::npos);
}

TEST(ReportPages, TimesOfAnEarlierRunAreMarked) {
    Report report;
    report.files.resize(1);
    report.files[0].experiments.resize(1);
    Experiment& e = report.files[0].experiments[0];
    e.grid = {{"x", {1.0, 2.0}}};
    e.columns = {{"s", formula("m.seconds")}, {"error", formula("m.y")}};
    ReportPlot plot;
    plot.title = "time", plot.x = formula("x"), plot.y = formula("m.seconds");
    e.plots = {plot};
    std::vector<ReportRow> rows = {row_with(1, 5), row_with(2, 6)};
    const auto dated = [&](const char* first, const char* second) {
        const char* runs[] = {first, second};
        for (std::size_t i = 0; i < 2; ++i) {
            StepRecord& step = rows[i].steps[0];
            step.name = "m-" + std::to_string(i), step.run_started = runs[i], step.figures["seconds"] = 3.0;
        }
        report.results = {{judged(e, rows)}};
        return report_page(report);
    };
    EXPECT_EQ(dated("2026-01-02T00:00:00Z", "2026-01-02T00:00:00Z").find("&dagger;"), std::string::npos);
    const std::string page = dated("2026-01-01T00:00:00Z", "2026-01-02T00:00:00Z");
    EXPECT_NE(page.find("<tr><td>1</td><td>3<span class=\"none\">&dagger;</span></td><td>5</td></tr>"),
              std::string::npos);
    EXPECT_NE(page.find("<tr><td>2</td><td>3</td><td>6</td></tr>"), std::string::npos);
    EXPECT_NE(page.find("1 of 2 points timed in an earlier run"), std::string::npos);
    EXPECT_EQ(rows_csv(report.results[0][0]), "x,s,error,timed in the run of\n1,3,5,2026-01-01T00:00:00Z\n"
                                              "2,3,6,2026-01-02T00:00:00Z\n");
    const auto json = report_json(report);
    EXPECT_EQ(json["runs"]["2026-01-01T00:00:00Z"], 1);
    EXPECT_EQ(json["files"][0]["experiments"][0]["rows"][1]["timed in the run of"][0],
              "2026-01-02T00:00:00Z");
    EXPECT_NE(dated("", "2026-01-02T00:00:00Z").find("(unknown) (1 steps), 2026-01-02"), std::string::npos);
}

TEST(ReportResults, ABandHoldsItsEndsAndNoNan) {
    Experiment e;
    e.grid = {{"x", {1.0}}};
    ReportCheck check;
    check.name = "y", check.value = formula("m.y"), check.least = formula("1"), check.most = formula("2*x");
    e.checks = {check};
    const auto verdict = [&](double y) { return judged(e, {row_with(1, y)}).checks.at(0).verdict; };
    EXPECT_EQ(verdict(1), Verdict::passed);
    EXPECT_EQ(verdict(2), Verdict::passed);
    EXPECT_EQ(verdict(2.0001), Verdict::failed);
    EXPECT_EQ(verdict(0.9999), Verdict::failed);
    EXPECT_EQ(verdict(std::nan("")), Verdict::failed);
    e.checks[0].known = "because";
    EXPECT_EQ(verdict(3), Verdict::known_failure);
    e.checks[0].value = formula("m.none");
    EXPECT_EQ(verdict(1), Verdict::failed);
    ReportRow absent = row_with(1, 1);
    absent.steps[0].done = false, absent.steps[0].absent = true, absent.steps[0].figures = {};
    EXPECT_EQ(judged(e, {absent}).checks.at(0).verdict, Verdict::not_run);
}

class ReportClouds : public testing::Test {
protected:
    std::vector<std::pair<std::string, Expression>> formulas(
        const std::vector<std::pair<const char*, const char*>>& texts) {
        std::vector<std::pair<std::string, Expression>> out;
        for (const auto& [target, text] : texts) out.emplace_back(target, formula(text));
        return out;
    }
    TempFolder folder_;
};

TEST_F(ReportClouds, AreMadeOfNothingByFormulas) {
    const std::string a = folder_.file("a.ply"), b = folder_.file("b.ply");
    const auto f = formulas({{"x", "i/n"}, {"y", "x"}, {"z", "r1 + g1"}, {"nz", "1"}, {"keep", "i != 3"}});
    EXPECT_EQ(make_cloud({}, 10, f, lookup, 1, false, a).at("points"), 9);
    make_cloud({}, 10, f, lookup, 1, false, b);
    EXPECT_EQ(read_bytes(a), read_bytes(b));
    make_cloud({}, 10, f, lookup, 2, false, b);
    EXPECT_NE(read_bytes(a), read_bytes(b));  // another seed
    const PointChunk points = read_all(a);
    EXPECT_DOUBLE_EQ(points.position[2].x, 0.2);
    EXPECT_DOUBLE_EQ(points.position[3].x, 0.4);  // without number 3
    EXPECT_DOUBLE_EQ(points.position[2].y, 0);    // formulas see the point as it was
    EXPECT_EQ(points.normal[0].z, 1);
    EXPECT_FALSE(std::filesystem::exists(folder_.file("a.truth")));
}

TEST_F(ReportClouds, GoOneBehindTheOtherWithTheirTruth) {
    const std::string a = folder_.file("a.ply"), b = folder_.file("b.ply");
    make_cloud({}, 4, formulas({{"x", "i"}, {"nz", "1"}, {"k1", "2"}, {"k2", "i"}}), lookup, 1, false, a);
    const auto said =
        make_cloud({a, a}, 0, formulas({{"x", "x + 10*file"}, {"k1", "k1/2"}}), lookup, 1, true, b);
    EXPECT_EQ(said.at("points"), 8);
    const PointChunk points = read_all(b);
    EXPECT_EQ(points.position[5].x, 11);
    EXPECT_NE(read_bytes(b).find("property float x"), std::string::npos);
    std::vector<double> truth(40);
    const std::string bytes = read_bytes(folder_.file("b.truth"));
    ASSERT_EQ(bytes.size(), 320u);
    std::memcpy(truth.data(), bytes.data(), 320);
    EXPECT_EQ(truth[5 * 5 + 3], 1);
    EXPECT_EQ(truth[5 * 5 + 4], 1);
}

TEST(ReportPlots, KeepEveryPointInTheFrame) {
    SvgPlot plot{"x & more", "y", true, true, {}};
    plot.curves.push_back({"a <curve>", {{1e-3, 1}, {1, 1e4}, {0, 5}, {1e3, 1e-8, true}}, -1, true});
    plot.curves.push_back({"one point", {{1, 1}}, 0, false});
    const std::string svg = svg_of(plot);
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_NE(svg.find("x &amp; more"), std::string::npos);
    EXPECT_NE(svg.find("a &lt;curve&gt;"), std::string::npos);
    EXPECT_NE(svg.find("stroke-dasharray"), std::string::npos);
    EXPECT_NE(svg.find("class=\"broken\""), std::string::npos);
    const std::regex circle("circle cx=\"([-0-9.]+)\" cy=\"([-0-9.]+)\"");
    for (std::sregex_iterator it(svg.begin(), svg.end(), circle), end; it != end; ++it) {
        EXPECT_GE(std::stod((*it)[1]), 74);
        EXPECT_LE(std::stod((*it)[2]), 348);
    }
    for (const bool log : {false, true})  // nothing to draw, and a single point
        for (const auto& points : {std::vector<SvgCurve::Point>{}, std::vector<SvgCurve::Point>{{0, 0}}})
            EXPECT_EQ(svg_of({"x", "y", log, log, {{"c", points, 0, false}}}).find("nan"), std::string::npos);
}

TEST(ReportFiles, AllReadyOnesAreUnderstood) {
    std::size_t n = 0;
    for (const auto& entry : std::filesystem::directory_iterator(SLIM_SOURCE_DIR "/configs/report")) {
        EXPECT_NO_THROW(read_report_files({entry.path().string()})) << entry.path();
        ++n;
    }
    EXPECT_EQ(n, 6u);
}

TEST(ReportFiles, ASettingChangesTheFilesThatHaveItsKeyAndIsRefusedWhereNoneHas) {
    const TempFolder folder;
    const std::string experiment = "[[experiment]]\nname = \"e\"\n";
    const std::string a = folder.file("a.toml"), b = folder.file("b.toml");
    folder.write("a.toml", "[values]\npoints = 10\nshape = \"torus\"\n" + experiment);
    folder.write("b.toml", "[values]\nnoise = 0.5\n" + experiment);
    const auto files = read_report_files({a, b}, {"values.points=20"});
    EXPECT_EQ(files.at(0).values.at(1).second.number, 20);
    EXPECT_EQ(files.at(1).values.size(), 1u);
    EXPECT_EQ(files.at(1).hash, read_report_files({b}).at(0).hash);
    for (const auto& [setting, expected] :
         {std::pair{"values.pionts=20", "'pionts' in its [values] (did you mean 'points'?)"},
          {"values.nosuch=1", "they have noise, points, shape"},
          {"experiment.name=x", "expected values.KEY=VALUE"},
          {"values.points=[1, 2]", "expected one value"},
          {"values.points", "expected values.KEY=VALUE"}}) {
        const std::string said = error_of([&, s = setting] { read_report_files({a, b}, {s}); });
        EXPECT_NE(said.find(expected), std::string::npos) << setting << ": " << said;
    }
}

TEST(ReportFiles, TheExtremesHaveEveryRow) {
    const ReportFile file = read_report_files({SLIM_SOURCE_DIR "/configs/report/extremes.toml"}).at(0);
    for (int row = 1; row <= 44; ++row)
        EXPECT_TRUE(std::any_of(file.experiments.begin(), file.experiments.end(), [&](const Experiment& e) {
            return e.row == std::to_string(row) && e.is_case();
        })) << row;
}

}  // namespace
}  // namespace slim::test
