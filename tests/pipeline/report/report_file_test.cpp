#include "pipeline/report/report_file.h"

#include "pipeline/report/report_cloud.h"
#include "pipeline/report/report_row.h"
#include "pipeline/report/svg_plot.h"
#include "tests/formats/file_support.h"
#include "tests/pipeline/report/report_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <regex>
#include <string>
#include <utility>
#include <vector>

namespace slim::test {
namespace {

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
    const auto f =
        formulas({{"x", "i/n"}, {"y", "x"}, {"z", "r1 + g1"}, {"nz", "1"}, {"keep", "i != 3"}});
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
    make_cloud({}, 4, formulas({{"x", "i"}, {"nz", "1"}, {"k1", "2"}, {"k2", "i"}}), lookup, 1,
               false, a);
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

TEST(ReportFiles, AllReadyOnesAreUnderstood) {
    std::size_t n = 0;
    for (const auto& entry :
         std::filesystem::directory_iterator(SLIM_SOURCE_DIR "/configs/report")) {
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
    const ReportFile file =
        read_report_files({SLIM_SOURCE_DIR "/configs/report/extremes.toml"}).at(0);
    for (int row = 1; row <= 44; ++row)
        EXPECT_TRUE(std::any_of(
            file.experiments.begin(), file.experiments.end(),
            [&](const Experiment& e) { return e.row == std::to_string(row) && e.is_case(); }))
            << row;
}

TEST(ReportPlots, KeepEveryPointInTheFrame) {
    SvgPlot plot{"x & more", "y", true, true, {}};
    plot.curves.push_back(
        {"a <curve>", {{1e-3, 1}, {1, 1e4}, {0, 5}, {1e3, 1e-8, true}}, -1, true});
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
    EXPECT_NE(svg.find("viewBox=\"0 0 640 "), std::string::npos);
    plot.curves[0].name = "a curve of so long a name";
    EXPECT_EQ(svg_of(plot).find("viewBox=\"0 0 640 "), std::string::npos) << "its end is cut off";
    for (const bool log : {false, true})  // nothing to draw, and a single point
        for (const auto& points :
             {std::vector<SvgCurve::Point>{}, std::vector<SvgCurve::Point>{{0, 0}}})
            EXPECT_EQ(svg_of({"x", "y", log, log, {{"c", points, 0, false}}}).find("nan"),
                      std::string::npos);
}

}  // namespace
}  // namespace slim::test
