#include "pipeline/report/report_file.h"
#include "pipeline/report/report_page.h"
#include "pipeline/report/report_results.h"
#include "pipeline/report/report_row.h"
#include "pipeline/report/report_text.h"
#include "pipeline/report/report_times.h"
#include "tests/pipeline/report/report_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace slim::test {
namespace {

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
    // one row below the cap
    EXPECT_EQ(judged(e, {row_with(1, 1)}).checks.at(0).verdict, Verdict::not_run);
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
            step.name = "m-" + std::to_string(i), step.run_started = runs[i],
            step.figures["seconds"] = 3.0;
        }
        report.results = {{judged(e, rows)}};
        return report_page(report);
    };
    EXPECT_EQ(dated("2026-01-02T00:00:00Z", "2026-01-02T00:00:00Z").find("&dagger;"),
              std::string::npos);
    const std::string page = dated("2026-01-01T00:00:00Z", "2026-01-02T00:00:00Z");
    EXPECT_NE(
        page.find("<tr><td>1</td><td>3<span class=\"none\">&dagger;</span></td><td>5</td></tr>"),
        std::string::npos);
    EXPECT_NE(page.find("<tr><td>2</td><td>3</td><td>6</td></tr>"), std::string::npos);
    EXPECT_NE(page.find("1 of 2 points timed in an earlier run"), std::string::npos);
    EXPECT_EQ(rows_csv(report.results[0][0]),
              "x,s,error,timed in the run of\n1,3,5,2026-01-01T00:00:00Z\n"
              "2,3,6,2026-01-02T00:00:00Z\n");
    const auto json = report_json(report);
    EXPECT_EQ(json["runs"]["2026-01-01T00:00:00Z"], 1);
    EXPECT_EQ(json["files"][0]["experiments"][0]["rows"][1]["timed in the run of"][0],
              "2026-01-02T00:00:00Z");
    EXPECT_NE(dated("", "2026-01-02T00:00:00Z").find("(unknown) (1 steps), 2026-01-02"),
              std::string::npos);
}

TEST(ReportResults, ABandHoldsItsEndsAndNoNan) {
    Experiment e;
    e.grid = {{"x", {1.0}}};
    ReportCheck check;
    check.name = "y", check.value = formula("m.y"), check.least = formula("1"),
    check.most = formula("2*x");
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

}  // namespace
}  // namespace slim::test
