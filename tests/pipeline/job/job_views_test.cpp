#include "pipeline/job/job.h"

#include "pipeline/job/job_source.h"
#include "tests/pipeline/job/job_support.h"

#include <gtest/gtest.h>

#include <filesystem>

namespace slim::test {
namespace {

namespace fs = std::filesystem;

TEST(Job, ViewsLeaveRoomForALegendIfAPictureOfTheJobHasOne) {
    const std::string views =
        "[input]\nfiles = ['a.ply']\n[[view]]\nname = 'a'\naovs = ['shaded']\n"
        "[[view]]\nname = 'b'\naovs = ['shaded']\nlegend = false\n"
        "[[view]]\nname = 'c'\naovs = ['normal']\ncamera = '0,0,9,0,0,0'\n";
    for (const JobStep& step : read_job(write_job(views)).steps)
        EXPECT_FALSE(has(step, "--legend-room")) << step.name;
    const Job job = read_job(write_job(views + "[[view]]\nname = 'd'\naovs = ['dir1']\n"));
    for (const int k : {1, 4})
        EXPECT_TRUE(has(job.steps[static_cast<std::size_t>(k)], "--legend-room")) << k;
    for (const int k : {2, 3})
        EXPECT_FALSE(has(job.steps[static_cast<std::size_t>(k)], "--legend-room")) << k;
    // A map takes that room by itself; keys of one kind alone take what they need.
    const Job maps = read_job(write_job(views + "[[view]]\nname = 'd'\naovs = ['mean']\n"));
    EXPECT_TRUE(has(maps.steps[1], "--legend-room"));
    EXPECT_FALSE(has(maps.steps[4], "--legend-room"));
    const Job keys = read_job(write_job(
        "[input]\nfiles = ['a.ply']\n[[view]]\nname = 'a'\naovs = ['hillshade']\n"
        "[[view]]\nname = 'b'\naovs = ['hillshade']\ncamera = 'iso'\n"));
    for (const JobStep& step : keys.steps) EXPECT_FALSE(has(step, "--legend-room")) << step.name;
}

/// Views of a model of degree 2, without colours and sharp surfels, beside options of a command
/// line.
Job drawing_of(const std::string& text, std::vector<TomlValue> options = {},
               const fs::path& picture = {}) {
    JobDrawing drawing{"m.slim", {}, "pictures", picture, {}};
    drawing.stages.degree = "2", drawing.stages.sharp = "off", drawing.stages.given = true;
    for (TomlValue& option : options) option.line = kOnCommandLine;
    drawing.options = std::move(options);
    return read_drawing(write_job(text), drawing);
}

std::string drawing_refusal(const std::string& text, std::vector<TomlValue> options = {}) {
    try {
        drawing_of(text, std::move(options));
        return "";
    } catch (const ConfigError& error) {
        return error.what();
    }
}

constexpr const char* kTwoViews =
    "[fit]\nnonsense = 3\n[render]\nsupersample = 2\n[[light]]\nkind = 'key'\n[[view]]\n"
    "name = 'a'\nsize = '64x48'\n[[view]]\nname = 'b'\naovs = ['mean']\n";

TEST(JobDrawing, IsTheViewsOfAModelWithoutInputAndFit) {
    const Job job = drawing_of(kTwoViews);
    ASSERT_EQ(job.steps.size(), 2u);
    EXPECT_EQ(job.steps[0].arguments[0], "m.slim");
    EXPECT_EQ(job.steps[0].output, fs::path("pictures/a.shaded.png"));
    EXPECT_EQ(job.steps[0].line, 7);
    EXPECT_TRUE(has(job.steps[0], "--supersample=2"));
    EXPECT_TRUE(has(job.steps[0], "--light=key"));
}

TEST(JobDrawing, OptionsWinOverAllThatTheJobSaysOfThem) {
    using Kind = Field::Kind;
    const Job job = drawing_of(kTwoViews, {{"size", Kind::text, false, {"320x240"}, 0},
                                           {"aov", Kind::text, true, {"shaded", "k1"}, 0},
                                           {"light", Kind::text, false, {"fill"}, 0},
                                           {"antialias", Kind::boolean, false, {"true"}, 0}});
    for (const JobStep& step : job.steps) {
        EXPECT_TRUE(has(step, "--size=320x240"));
        EXPECT_FALSE(has(step, "--size=64x48"));
        EXPECT_TRUE(has(step, "--aov=shaded,k1"));
        EXPECT_TRUE(has(step, "--light=fill"));
        EXPECT_TRUE(has(step, "--antialias"));
        EXPECT_FALSE(has(step, "--supersample=2"));
    }
}

TEST(JobDrawing, LeavesOutWhatOtherPicturesThanTheJobsHaveNoUseFor) {
    const std::string text =
        "[render]\ntruth_shape = 'bumpy'\n[[view]]\naovs = ['hillshade', 'truth_distance']\n"
        "contours = '2'\n";
    EXPECT_TRUE(has(drawing_of(text).steps[0], "--contours=2"));
    const Job job = drawing_of(text, {{"aov", Field::Kind::text, true, {"depth"}, 0}});
    EXPECT_FALSE(has(job.steps[0], "--contours=2"));
    EXPECT_FALSE(has(job.steps[0], "--truth-shape=bumpy"));
    EXPECT_NE(drawing_refusal(text, {{"sun", Field::Kind::real, true, {"3", "4"}, 0},
                                     {"aov", Field::Kind::text, true, {"depth"}, 0}})
                  .find("(no view of "),
              std::string::npos);
}

TEST(JobDrawing, AFormatOfExrMeansEXRsInTheFolder) {
    const Job job = drawing_of(kTwoViews, {{"format", Field::Kind::text, false, {"exr"}, 0}});
    EXPECT_EQ(job.steps[0].output, fs::path("pictures/a.exr"));
    EXPECT_EQ(job.steps[1].output, fs::path("pictures/b.exr"));
    EXPECT_EQ(job.steps[1].products,
              (std::vector<fs::path>{"pictures/b.exr", "pictures/b.png"}));
    EXPECT_TRUE(has(job.steps[1], "--format=exr"));
    // The others of a job stay PNGs.
    const Job mixed = read_job(
        write_job("[input]\nfiles = ['a.ply']\n[[view]]\nname = 'a'\nformat = 'exr'\n"
                  "turntable = 2\n[[view]]\nname = 'b'\n"));
    EXPECT_EQ(mixed.steps[1].products.size(), 4u);
    EXPECT_EQ(mixed.steps[1].products[2].filename(), "a_0002.exr");
    EXPECT_EQ(mixed.steps[2].output.filename(), "b.shaded.png");
}

/// What a step's argument says after that beginning, empty without it.
std::string said(const JobStep& step, const std::string& begin) {
    for (const std::string& argument : step.arguments)
        if (argument.starts_with(begin)) return argument.substr(begin.size());
    return "";
}

TEST(JobDrawing, EachViewWithLinesWritesAFileOfItsOwn) {
    const std::string text =
        "[[view]]\nname = 'a'\nlines = ['contour']\n[[view]]\nname = 'b'\n"
        "aovs = ['lines']\nlines = ['contour']\n[[view]]\nname = 'c'\n";
    const std::vector<TomlValue> options = {
        {"lines_ply", Field::Kind::text, false, {"/x/e.ply"}, 0},
        {"lines_obj", Field::Kind::text, false, {"/x/e.obj"}, 0}};
    const Job job = drawing_of(text, options);
    EXPECT_EQ(said(job.steps[0], "--lines-ply="), "/x/a.e.ply");
    EXPECT_EQ(said(job.steps[0], "--lines-obj="), "/x/a.e.obj");
    EXPECT_EQ(said(job.steps[1], "--lines-ply="), "/x/b.e.ply");
    EXPECT_EQ(said(job.steps[2], "--lines-ply="), "") << "a view without lines writes none";
    EXPECT_EQ(job.steps[0].products.back(), fs::path("/x/a.e.obj"));
    // One view keeps the name.
    const Job one = drawing_of("[[view]]\nlines = ['contour']\n", options);
    EXPECT_EQ(said(one.steps[0], "--lines-ply="), "/x/e.ply");
    EXPECT_NE(drawing_refusal("[[view]]\n[[view]]\nname = 'b'\n", options)
                  .find("lines_ply is for a drawing of lines, which is not asked for: --lines or "
                        "--aov lines (no view of "),
              std::string::npos);
}

TEST(Job, LineFilesOfAllViewsAreNamedAsPicturesAndThoseOfOneAreItsOwn) {
    const std::string begin = "[input]\nfiles = ['a.ply']\n[render]\nlines = ['contour']\n";
    const std::string two = "[[view]]\nname = 'a'\n[[view]]\nname = 'b'\n";
    const Job job = read_job(write_job(begin + "lines_ply = 'e.ply'\n" + two));
    const fs::path folder = job_folder();
    EXPECT_EQ(said(job.steps[1], "--lines-ply="), (folder / "a.e.ply").string());
    EXPECT_EQ(said(job.steps[2], "--lines-ply="), (folder / "b.e.ply").string());
    const std::string named = "lines_ply = 'e.ply'\n";
    EXPECT_EQ(said(read_job(write_job(begin + two + named)).steps[2], "--lines-ply="),
              (folder / "e.ply").string());
    // Never two of one file, nor one over a cloud.
    EXPECT_NE(refusal(begin + "[[view]]\nname = 'a'\n" + named + "[[view]]\nname = 'b'\n" + named)
                  .find(":8: view b would write its lines to " + (folder / "e.ply").string() +
                        ", which view a writes too"),
              std::string::npos);
    EXPECT_NE(refusal(begin + "[[view]]\nlines_ply = 'a.ply'\n").find("which build reads"),
              std::string::npos);
}

TEST(JobDrawing, SaysWhatItCannotDrawAndWhere) {
    const fs::path file = job_folder() / "job.toml";
    EXPECT_EQ(drawing_refusal("[render]\nsize = '9x9'\n"),
              file.string() + ": no [[view]]: there is nothing to draw");
    EXPECT_EQ(drawing_refusal("[[view]]\naovs = ['e1']\n"),
              file.string() + ":2: aov e1 needs third derivatives, which a model of degree 2 does "
                              "not have: expected a model built with --degree 3");
    EXPECT_EQ(drawing_refusal("[[view]]\n", {{"size", Field::Kind::text, false, {"9"}, 0}}),
              file.string() + ", command line: size: expected WIDTHxHEIGHT, each 1 to 32768; "
                              "found '9'");
    EXPECT_THROW(drawing_of(kTwoViews, {}, "x.png"), ConfigError);
    EXPECT_EQ(drawing_of("[[view]]\n", {}, "x.png").steps[0].output, fs::path("x.png"));
}

TEST(Job, NamesTheTruthOnlyToViewsThatShowIt) {
    const Job job =
        read_job(write_job("[input]\nfiles = ['a.ply']\n[render]\ntruth_shape = 'torus'\n"
                           "[[view]]\nname = 'a'\naovs = ['truth_distance']\n[[view]]\nname = 'b'\n"
                           "aovs = ['mean']\n"));
    EXPECT_TRUE(has(job.steps[1], "--truth-shape=torus"));
    EXPECT_FALSE(has(job.steps[2], "--truth-shape=torus"));
}

TEST(Job, WhatIsSetTakesThePlaceOfTheFilesOtherWayToSmoothEdges) {
    const auto view_of = [](const std::string& render, std::vector<std::string> settings) {
        return read_job(write_job("[input]\nfiles = ['a.ply']\n[render]\n" + render +
                                  "[[view]]\nname = 'a'\n"),
                        settings)
            .steps[1];
    };
    const JobStep once = view_of("supersample = 2\n", {"render.antialias=true"});
    EXPECT_TRUE(has(once, "--antialias"));
    EXPECT_FALSE(has(once, "--supersample=2"));
    const JobStep twice = view_of("antialias = true\n", {"render.supersample=2"});
    EXPECT_TRUE(has(twice, "--supersample=2"));
    EXPECT_FALSE(has(twice, "--antialias"));
    // What changes nothing takes no place; what is said in one place contradicts itself.
    EXPECT_TRUE(has(view_of("supersample = 2\n", {"render.antialias=false"}), "--supersample=2"));
    EXPECT_TRUE(has(view_of("antialias = true\n", {"render.supersample=1"}), "--antialias"));
    EXPECT_THROW(view_of("supersample = 2\nantialias = true\n", {}), ConfigError);
    EXPECT_THROW(view_of("", {"render.supersample=2", "render.antialias=true"}), ConfigError);
}

TEST(Job, AViewsOwnWayToSmoothEdgesTakesThePlaceOfThatOfAllViews) {
    const auto views_of = [](const std::string& render, const std::string& view,
                             std::vector<std::string> settings) {
        return read_job(write_job("[input]\nfiles = ['a.ply']\n[render]\n" + render +
                                  "[[view]]\nname = 'a'\n" + view +
                                  "[[view]]\nname = 'b'\ncamera = 'iso'\n"),
                        settings);
    };
    const auto check = [&](const Job& job, bool own_antialias) {
        const JobStep &own = job.steps[1], &other = job.steps[2];
        EXPECT_EQ(has(own, "--antialias"), own_antialias);
        EXPECT_EQ(has(own, "--supersample=2"), !own_antialias);
        EXPECT_EQ(has(other, "--antialias"), !own_antialias);
        EXPECT_EQ(has(other, "--supersample=2"), own_antialias);
    };
    check(views_of("antialias = true\n", "supersample = 2\n", {}), false);
    check(views_of("", "supersample = 2\n", {"render.antialias=true"}), false);
    check(views_of("supersample = 2\n", "antialias = true\n", {}), true);
    check(views_of("", "antialias = true\n", {"render.supersample=2"}), true);
    // What changes nothing takes no place, and a view that says both contradicts itself.
    const Job same = views_of("antialias = true\n", "supersample = 1\n", {});
    EXPECT_TRUE(has(same.steps[1], "--antialias"));
    EXPECT_TRUE(has(views_of("supersample = 2\n", "antialias = false\n", {}).steps[1],
                    "--supersample=2"));
    EXPECT_THROW(views_of("", "supersample = 2\nantialias = true\n", {}), ConfigError);
    // If no view is left, the setting has no effect but stands in nobody's way.
    const Job one = read_job(write_job("[input]\nfiles = ['a.ply']\n[[view]]\nsupersample = 2\n"),
                             {"render.antialias=true"});
    EXPECT_FALSE(has(one.steps[1], "--antialias"));
}

TEST(Job, LightTablesBecomeOneOption) {
    const Job job = read_job(write_job(
        "[input]\nfiles = ['a.ply']\n[render]\nmode = 'raytrace'\n"
        "[[light]]\nkind = 'sun'\nazimuth = 300\nangle = 2.5\n"
        "[[light]]\nkind = 'rect'\nat = [1, 2, 3]\nsize = [1, 0.5]\nshadows = false\n"
        "[[view]]\nname = 'a'\nadd = ['b.slim']\n"));
    const JobStep& view = job.steps[1];
    EXPECT_TRUE(
        has(view, "--light=sun azimuth=300 angle=2.5; rect at=1,2,3 size=1,0.5 shadows=false"));
    // A model that is added is an input, found beside the job.
    EXPECT_EQ(view.inputs.back(), job_folder() / "b.slim");
}

TEST(Job, BadLightsAreRefusedWithTheirLine) {
    const std::string begin = "[input]\nfiles = ['a.ply']\n";
    const auto message = [&](const std::string& rest) {
        try {
            read_job(write_job(begin + rest + "\n[[view]]\n"));
        } catch (const ConfigError& e) {
            return std::string(e.what());
        }
        return std::string("accepted");
    };
    EXPECT_NE(message("[[light]]\nkind = 'son'").find(":3: "), std::string::npos);
    EXPECT_NE(message("[[light]]\nkind = 'sun'\nheight = 3").find("'height'"), std::string::npos);
    EXPECT_NE(message("[render]\nlight = 'sonne'").find(":4: "), std::string::npos);
    EXPECT_NE(message("[render]\nlight = 'sun'\n[[light]]\nkind = 'key'").find("one of the two"),
              std::string::npos);
    EXPECT_NE(message("[render]\nao = true").find("ao needs rays"), std::string::npos);
}

TEST(Job, OptionsOfAllViewsGoToThoseThatTakeThemAndAreRefusedWhereNoneDoes) {
    const std::string begin =
        "[input]\nfiles = ['a.ply']\n[render]\nmode = 'raytrace'\nao_samples = 9\n"
        "ground = true\nground_color = '#112233'\nambient = 2\n";
    const std::string map = "[[view]]\nname = 'map'\naovs = ['mean']\n";
    const Job job = read_job(write_job(
        begin + map + "[[view]]\nname = 'a'\nao = true\n[[view]]\nname = 'b'\naovs = ['ao']\n"));
    for (const char* option :
         {"--ao-samples=9", "--ground", "--ground-color=#112233", "--ambient=2"}) {
        EXPECT_FALSE(has(job.steps[1], option)) << option;
        EXPECT_TRUE(has(job.steps[2], option)) << option;
    }
    EXPECT_TRUE(has(job.steps[3], "--ao-samples=9"));
    EXPECT_FALSE(has(job.steps[3], "--ambient=2"));
    const auto message = [&](const std::string& text) {
        try {
            read_job(write_job(text));
        } catch (const ConfigError& e) {
            return std::string(e.what());
        }
        return std::string("accepted");
    };
    EXPECT_NE(message(begin + map).find(":8: ambient is for the aov shaded, which is not asked "
                                       "for (no view takes it)"),
              std::string::npos)
        << message(begin + map);
    EXPECT_NE(message(begin + "[[view]]\n").find(":5: ao_samples is for"),
              std::string::npos);
    EXPECT_NE(message("[input]\nfiles = ['a.ply']\n[[view]]\naovs = ['mean']\nambient = 2\n")
                  .find("ambient is for"),
              std::string::npos);
}

TEST(Job, LightsAndContoursAreForViewsThatShowThem) {
    const Job job = read_job(write_job(
        "[input]\nfiles = ['a.ply']\n[render]\ncontours = '2'\nmatcap = 'ball.png'\n"
        "[[view]]\nname = 'a'\naovs = ['hillshade']\n[[view]]\nname = 'b'\naovs = ['matcap']\n"));
    EXPECT_TRUE(has(job.steps[1], "--contours=2"));
    EXPECT_FALSE(has(job.steps[2], "--contours=2"));
    const std::string ball = "--matcap=" + (job_folder() / "ball.png").string();
    EXPECT_FALSE(has(job.steps[1], ball));
    EXPECT_TRUE(has(job.steps[2], ball));
}

TEST(Job, AViewsListReplacesThatOfAllViews) {
    const Job job = read_job(write_job(
        "[input]\nfiles = ['a.ply']\n[render]\nsun = [300, 30]\nlines = ['contour']\n"
        "[[view]]\naovs = ['hillshade']\nsun = [90, 20]\nlines = ['suggestive']\n"));
    EXPECT_TRUE(has(job.steps[1], "--sun=90,20"));
    EXPECT_FALSE(has(job.steps[1], "--sun=300,30"));
    EXPECT_TRUE(has(job.steps[1], "--lines=suggestive"));
    EXPECT_FALSE(has(job.steps[1], "--lines=contour"));
}

TEST(Job, PicturesThatLightAViewAreItsInputs) {
    const Job job = read_job(write_job(
        "[input]\nfiles = ['a.ply']\n[render]\nmatcap = 'ball.png'\nenvironment = 'sky.exr'\n"
        "[[view]]\naovs = ['matcap']\n[[view]]\nname = 'b'\naovs = ['environment']\n"));
    const fs::path folder = job_folder();
    EXPECT_EQ(job.steps[1].inputs.back(), folder / "ball.png");
    EXPECT_EQ(job.steps[2].inputs.back(), folder / "sky.exr");
}

TEST(Job, StylesOfAWrongNameAreGuessed) {
    JobSource source;
    source.job = "plat", source.clouds = {"a.ply"};
    try {
        job_file(source);
        FAIL();
    } catch (const ConfigError& error) {
        EXPECT_NE(std::string(error.what()).find("did you mean 'plate'?"), std::string::npos)
            << error.what();
    }
}

TEST(Job, CloudsOfTheCommandLineMayHaveAnyNameThatIsUTF8) {
    const fs::path file = write_job("[input]\nfiles = ['a.ply']\n");
    for (const std::string name : {"new\nl/s.ply", "a\tb.ply", "back\\slash.ply", "c\x01\x7f.ply",
                                   "quote\".ply", "[a, b].ply", "comma,comma.ply", "\u00e9.ply"}) {
        SCOPED_TRACE(name);
        const JobSource source{file.string(), {"/x/" + name, "/y.ply"}, "/out/" + name, {}};
        const Job job = read_job(file, job_settings(source));
        EXPECT_EQ(job.folder, "/out/" + name);
        EXPECT_EQ(job.steps[0].inputs,
                  (std::vector<fs::path>{"/x/" + name, "/y.ply"}));
    }
    const JobSource latin{file.string(), {"/x/caf\xe9.ply"}, "/out", {}};
    try {
        job_settings(latin);
        FAIL();
    } catch (const ConfigError& error) {
        EXPECT_NE(std::string(error.what()).find("no UTF-8"), std::string::npos) << error.what();
    }
}

TEST(Job, ListsMayBeWrittenAsOnACommandLine) {
    const Job job = read_job(write_job("[input]\nfiles = 'a.ply,b.ply'\n[render]\n"
                                       "lines = 'contour,crest'\n[[view]]\naovs = 'shaded,mean'\n"
                                       "[output]\naovs = 'k1'\n"),
                             {"render.range=mean=2,k1=3"});
    const JobStep& view = job.steps.back();
    EXPECT_TRUE(has(view, "--lines=contour,crest"));
    EXPECT_TRUE(has(view, "--aov=shaded,mean"));
    EXPECT_TRUE(has(view, "--range=mean=2,k1=3"));
    EXPECT_TRUE(has(job.steps[0], (job_folder() / "a.ply").string()));
    EXPECT_TRUE(has(job.steps[0], (job_folder() / "b.ply").string()));
    EXPECT_NE(refusal("[input]\nfiles = 'a.ply'\n[render]\nlines = 'contour,crset'\n[[view]]\n")
                  .find(":4: lines: expected one of"),
              std::string::npos);
}

TEST(Job, TheFilmStyleLooksDownAndItsCameraIsSet) {
    JobSource source;
    source.job = "film", source.clouds = {"a.ply"};
    const auto view_of = [&](std::vector<std::string> more) {
        std::vector<std::string> settings = job_settings(source);
        settings.insert(settings.end(), more.begin(), more.end());
        return read_job(job_file(source), settings).steps.back();
    };
    EXPECT_TRUE(has(view_of({"render.up=z"}), "--camera=iso"));
    EXPECT_TRUE(has(view_of({"render.camera=front"}), "--camera=front"));
    EXPECT_FALSE(has(view_of({"render.camera=front"}), "--camera=iso"));
}

}  // namespace
}  // namespace slim::test
