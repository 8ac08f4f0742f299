#include "pipeline/job/job_left_out.h"

#include "pipeline/job/job.h"
#include "pipeline/job/job_source.h"
#include "tests/pipeline/job/job_support.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace slim::test {
namespace {

TEST(Job, SaysWhichRaysAreNotCast) {
    const auto left_out = [&](const std::string& render) {
        const Job job =
            read_job(write_job("[input]\nfiles = ['a.ply']\n[render]\n" + render + "\n[[view]]\n"));
        std::string all;
        for (const std::string& line : job.left_out) all += line + "\n";
        return all;
    };
    EXPECT_NE(left_out("mode = 'forward'").find("rays: "), std::string::npos);
    EXPECT_EQ(left_out("mode = 'raytrace'").find("rays: "), std::string::npos);
    EXPECT_EQ(left_out("mode = 'raytrace'").find("shadows: "), std::string::npos);
    EXPECT_NE(left_out("mode = 'raytrace'\nshadows = false").find("shadows: "), std::string::npos);
    EXPECT_NE(left_out("mode = 'raytrace'").find("ambient occlusion: "), std::string::npos);
    EXPECT_EQ(left_out("mode = 'raytrace'\nao = true").find("ambient occlusion: "),
              std::string::npos);
}

TEST(Job, SaysWhatIsLeftOut) {
    const auto left_out = [](const std::string& text) {
        const Job job = read_job(write_job(text));
        std::string all;
        for (const std::string& reason : job.left_out) all += reason + "\n";
        return all;
    };
    const std::string plain = left_out(
        "[input]\nfiles = ['a.ply']\n[[view]]\ncamera = 'front'\n[output]\nhtml = false\n");
    for (const char* part : {"curvature: no AOV and no line asks for it", "colours: color = false",
                             "measure:", "scan:", "index.html:", "normal"})
        EXPECT_NE(plain.find(part), std::string::npos) << part;
    // What "all" cannot have is missing, not unasked for.
    const std::string all =
        left_out("[input]\nfiles = ['a.ply']\n[[view]]\ncamera = 'front'\naovs = ['all']\n");
    EXPECT_EQ(all.find("pictures of"), std::string::npos) << all;
    EXPECT_NE(all.find("no line that can be drawn"), std::string::npos) << all;
    const std::string demo = left_out(kDemo);
    for (const char* part : {"curvature: no", "measure:", "scan:", "index.html:"})
        EXPECT_EQ(demo.find(part), std::string::npos) << part;
}

TEST(Job, WhatLinesTakeIsNotLeftOut) {
    const auto left_out = [](const std::string& fit, const std::string& view) {
        const Job job =
            read_job(write_job("[input]\nfiles = ['a.ply']\n[fit]\n" + fit + "[[view]]\n" + view));
        std::string all;
        for (const std::string& reason : job.left_out) all += reason + "\n";
        return all;
    };
    const auto has_line = [](const std::string& text, const char* what) {
        return text.find(what) != std::string::npos;
    };
    struct Case {
        const char *fit, *view;
        bool second, third;  // derivatives are computed
    };
    for (const Case& c :
         {Case{"degree = 3\n", "lines = ['contour']\n", false, false},
          {"degree = 3\n", "aovs = ['lines']\nlines = ['contour', 'reflection']\n", false, false},
          {"degree = 3\nsharp = 'on'\n", "lines = ['crease']\n", false, false},
          {"degree = 3\n", "lines = ['parabolic']\n", true, false},
          {"degree = 2\n", "lines = ['suggestive']\n", true, false},
          {"degree = 3\n", "lines = ['suggestive']\n", true, true},
          {"degree = 'auto'\n", "lines = ['crest']\n", true, true},
          {"degree = 2\n", "aovs = ['lines']\n", true, false},
          {"degree = 3\n", "aovs = ['all']\n", true, true},
          {"degree = 2\n", "aovs = ['all']\n", true, false},
          {"degree = 3\n", "aovs = ['dir1']\n", true, false}}) {
        const std::string text = left_out(c.fit, c.view);
        EXPECT_EQ(has_line(text, "curvature: "), !c.second) << c.fit << c.view << text;
        EXPECT_EQ(has_line(text, "third derivatives: "), !c.third) << c.fit << c.view << text;
    }
    EXPECT_TRUE(has_line(left_out("", ""), "or more than 4.4 % of the places"));
    for (const char* sharp : {"sharp = 'on'\n", "sharp = 'off'\n"})
        EXPECT_FALSE(has_line(left_out(sharp, ""), "sharp surfels: ")) << sharp;
    EXPECT_TRUE(has_line(left_out("color = true\n", ""), "colours: no view shows them"));
    EXPECT_FALSE(has_line(left_out("color = true\n", "aovs = ['color']\n"), "colours: "));
    EXPECT_FALSE(has_line(left_out("color = true\n", "aovs = ['all']\n"), "colours: "));
}

TEST(Job, SaysWhatThePointsDecidedWhenTheModelWasLastBuilt) {
    const auto said = [](const std::string& fit, const std::string& result) {
        const Job job =
            read_job(write_job("[input]\nfiles = ['a.ply']\n[output]\ndir = 'o'\n[fit]\n" + fit));
        std::filesystem::create_directories(job.folder);
        std::ofstream(job.steps[0].target) << result;
        const std::string text = explanation_of(job);
        std::filesystem::remove(job.steps[0].target);
        const auto at = text.find("As the model was last built: ");
        return at == std::string::npos ? "" : text.substr(at, text.find('\n', at) - at);
    };
    const std::string built =
        R"({"result": {"sharp": true, "edge_share": 0.25, "edge_places": 32}})";
    EXPECT_EQ(said("", built),
              "As the model was last built: sharp edges: at 25.0 % of the 32 places looked at, "
              "above 4.4 %: with sharp surfels (fit.sharp = \"off\": without)");
    EXPECT_EQ(said("sharp = 'on'\n", built), "");
    EXPECT_EQ(said("", R"({"result": {"sharp": true}})"), "");
    EXPECT_EQ(said("", "half a manif"), "");
}

TEST(Job, SaysWhatWillBeMissing) {
    const auto missing = [](const std::string& fit, const std::string& view) {
        const Job job = read_job(write_job("[input]\nfiles = ['a.ply']\n[fit]\n" + fit +
                                           "[[view]]\nname = 'v'\n" + view));
        const std::string text = explanation_of(job);
        EXPECT_EQ(text.find("will be missing:\n") != std::string::npos, !job.missing.empty());
        EXPECT_EQ(text.find("may be missing, as the points decide:\n") != std::string::npos,
                  !job.uncertain.empty());
        std::string all;
        for (const std::string& reason : job.missing) all += reason + "\n";
        for (const std::string& reason : job.uncertain) all += "may be: " + reason + "\n";
        return all;
    };
    const std::string drawing = "lines = ['contour', 'suggestive', 'crest', 'crease']\n";
    EXPECT_EQ(missing("degree = 3\nsharp = 'on'\n", drawing), "");
    EXPECT_EQ(
        missing("degree = 2\n", drawing),
        "view v: crest lines: they need degree = 3 in [fit]\n"
        "may be: view v: crease lines: drawn if the points lie at edges enough for sharp surfels: "
        "sharp = \"on\" in [fit] has these always\n");
    EXPECT_EQ(missing("degree = 3\nsharp = 'off'\n", drawing),
              "view v: crease lines: they need sharp surfels: sharp = \"on\" in [fit]\n");
    EXPECT_EQ(missing("degree = 1\nsharp = 'on'\n", drawing),
              "view v: suggestive lines: they need degree = 2 in [fit]\n"
              "view v: crest lines: they need degree = 3 in [fit]\n");
    const std::string all = missing("degree = 2\n", "aovs = ['all']\n");
    for (const char* aov :
         {"e1, e2, dk1_dt2, dk2_dt1 of aov all", "color of", "ao of", "truth_distance of"})
        EXPECT_NE(all.find(aov), std::string::npos) << aov << all;
}

TEST(Job, SaysWhatSeveralViewsLackOnceWithTheirNames) {
    const Job job = read_job(write_job(
        "[input]\nfiles = ['a.ply']\n[fit]\ndegree = 2\n[render]\nlines = 'contour,crest,crease'\n"
        "[[view]]\nname = 'a'\n[[view]]\nname = 'b'\nlines = 'contour'\n[[view]]\nname = 'c'\n"));
    const std::vector<std::string> crest{"views a, c: crest lines: they need degree = 3 in [fit]"};
    EXPECT_EQ(job.missing, crest);
    ASSERT_EQ(job.uncertain.size(), 1u);
    EXPECT_TRUE(job.uncertain[0].starts_with("views a, c: crease lines: "));
}

TEST(Job, NamesWhatIsLeftOutInALine) {
    const Job job = read_job(write_job("[input]\nfiles = ['a.ply']\n[[view]]\n"));
    EXPECT_GT(job.left_out.size(), 7u);
    EXPECT_EQ(left_out_in_a_line(job.left_out, "HOW"),
              "left out: measure, curvature, third derivatives, feature lines, colours, rays, scan "
              "(why: HOW)");
    EXPECT_EQ(left_out_in_a_line({}, "HOW"), "");
}

TEST(Job, ExplainsWhatARunRefuses) {
    const std::string begin = "[input]\nfiles = ['a.ply']\n[fit]\ndegree = 2\n";
    const auto file = write_job(begin + "[[view]]\nname = 'v'\nlines = ['crest']\n" +
                                "[[view]]\nname = 'w'\naovs = ['e1']\n[[view]]\nname = 'x'\n");
    const Job job = read_job_to_explain(file);
    ASSERT_EQ(job.refused.size(), 2u);
    EXPECT_EQ(job.refused[0].what(),
              file.string() + ":7: lines crest need third derivatives, which a model of degree 2 "
                              "does not have: expected degree = 3 in [fit]");
    const std::string text = explanation_of(job);
    EXPECT_TRUE(text.starts_with("`slim run` refuses this job:\n  " +
                                 std::string(job.refused[0].what()) + "\n"))
        << text;
    EXPECT_NE(text.find(":10: aov e1 needs"), std::string::npos) << text;
    EXPECT_NE(text.find("view x: slim render"), std::string::npos) << text;
    EXPECT_TRUE(job.missing.empty()) << job.missing[0];  // said once
    try {
        read_job(file);
        ADD_FAILURE() << "a run takes it";
    } catch (const ConfigError& error) {
        EXPECT_STREQ(error.what(), job.refused[0].what());
    }
    const std::string sound = explanation_of(read_job(write_job(begin + "[[view]]\n")));
    EXPECT_TRUE(sound.starts_with("`slim run` does, in this order:\n")) << sound;
}

}  // namespace
}  // namespace slim::test
