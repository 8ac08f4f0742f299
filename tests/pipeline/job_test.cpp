#include "pipeline/job.h"

#include "pipeline/job_source.h"
#include "tests/pipeline/job_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

namespace slim::test {
namespace {

namespace fs = std::filesystem;

TEST(Job, BecomesStepsInOrder) {
    const Job job = read_job(write_job(kDemo));
    std::vector<std::string> names;
    for (const JobStep& step : job.steps) names.push_back(step.name);
    EXPECT_EQ(names,
              (std::vector<std::string>{"scan", "build", "measure", "view front", "view iso"}));
    EXPECT_EQ(job.folder, job_folder() / "out");
}

TEST(Job, PassesOptionsOnToTheVerbs) {
    const Job job = read_job(write_job(kDemo));
    EXPECT_EQ(job.steps[0].arguments[0], "sculpture");
    EXPECT_TRUE(has(job.steps[0], "--points=1000"));
    EXPECT_TRUE(has(job.steps[0], "--noise=0.001"));
    EXPECT_TRUE(has(job.steps[1], "--degree=3"));
    EXPECT_TRUE(has(job.steps[1], (job.folder / "cloud.ply").string()));
    EXPECT_TRUE(has(job.steps[3], "--camera=front"));
    EXPECT_TRUE(has(job.steps[3], "--size=640x480"));
    EXPECT_TRUE(has(job.steps[3], "--aov=shaded,k1"));
    EXPECT_TRUE(has(job.steps[3], (job.folder / "front.png").string()));
    EXPECT_TRUE(has(job.steps[4], "--aov=mean"));
    EXPECT_TRUE(has(job.steps[4], (job.folder / "iso.mean.png").string()));
    // A view's own size takes the place of the common one.
    EXPECT_TRUE(has(job.steps[4], "--size=320x240"));
    EXPECT_FALSE(has(job.steps[4], "--size=640x480"));
}

TEST(Job, ViewsLeaveRoomForALegendIfAPictureOfTheJobHasOne) {
    const std::string views =
        "[input]\nfiles = ['a.ply']\n[[view]]\nname = 'a'\naovs = ['shaded']\n"
        "[[view]]\nname = 'b'\naovs = ['shaded']\nlegend = false\n"
        "[[view]]\nname = 'c'\naovs = ['normal']\ncamera = '0,0,9,0,0,0'\n";
    for (const JobStep& step : read_job(write_job(views)).steps)
        EXPECT_FALSE(has(step, "--legend-room")) << step.name;
    const Job job = read_job(write_job(views + "[[view]]\nname = 'd'\naovs = ['dir1']\n"));
    EXPECT_TRUE(has(job.steps[1], "--legend-room"));
    for (const int k : {2, 3, 4})
        EXPECT_FALSE(has(job.steps[static_cast<std::size_t>(k)], "--legend-room")) << k;
}

TEST(Job, NamesTheTruthOnlyToViewsThatShowIt) {
    const Job job =
        read_job(write_job("[input]\nfiles = ['a.ply']\n[render]\ntruth_shape = 'torus'\n"
                           "[[view]]\nname = 'a'\naovs = ['truth_distance']\n[[view]]\nname = 'b'\n"
                           "aovs = ['mean']\n"));
    EXPECT_TRUE(has(job.steps[1], "--truth-shape=torus"));
    EXPECT_FALSE(has(job.steps[2], "--truth-shape=torus"));
}

TEST(Job, MeasuresOfCloudsThatAreNamedAlikeAreTheirOwn) {
    const Job job =
        read_job(write_job("[input]\nfiles = ['a/scan.ply', 'b/scan.ply', 'c.ply', 'd e.ply', "
                           "'d_e.ply']\n[measure]\n"));
    std::vector<std::string> outputs;
    for (const JobStep& step : job.steps)
        if (step.verb == "measure") outputs.push_back(step.output.filename().string());
    EXPECT_EQ(outputs, (std::vector<std::string>{"measure_scan.ply.json", "measure_scan.ply_2.json",
                                                 "measure_c.ply.json", "measure_d_e.ply.json",
                                                 "measure_d_e.ply_2.json"}));
    EXPECT_EQ(job.steps[2].name, "measure scan.ply 2");
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
    EXPECT_NE(message("[render]\nao = true").find("--mode raytrace"), std::string::npos);
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
    EXPECT_NE(message(begin + map).find(":8: no view takes it: ambient is for the aov shaded"),
              std::string::npos)
        << message(begin + map);
    EXPECT_NE(message(begin + "[[view]]\n").find(":5: no view takes it: ao_samples"),
              std::string::npos);
    EXPECT_NE(message("[input]\nfiles = ['a.ply']\n[[view]]\naovs = ['mean']\nambient = 2\n")
                  .find("ambient is for"),
              std::string::npos);
}

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

TEST(Job, FilmsLeaveNumberedPictures) {
    const Job job = read_job(write_job(
        "[input]\nfiles = ['a.ply']\n[[view]]\nname = 'a'\nturntable = 3\naovs = ['mean']\n"
        "lines = ['contour']\n[[view]]\nname = 'b'\npath = 'front; iso zoom 2'\nframes = 2\n"));
    const fs::path folder = job.folder;
    EXPECT_EQ(job.steps[1].products,
              (std::vector<fs::path>{folder / "a.mean_0001.png", folder / "a_0001.lines.svg",
                                     folder / "a.mean_0002.png", folder / "a_0002.lines.svg",
                                     folder / "a.mean_0003.png", folder / "a_0003.lines.svg"}));
    EXPECT_EQ(job.steps[2].products.size(), 2u);
    EXPECT_THROW(read_job(write_job("[input]\nfiles = ['a.ply']\n[[view]]\nframes = 3\n")),
                 ConfigError);
}

TEST(Job, ReadsFilesFromBesideItself) {
    const Job job = read_job(write_job("[input]\nfiles = ['a.ply', 'sub/b.ply']\n[measure]\n"));
    ASSERT_EQ(job.steps.size(), 3u);
    EXPECT_EQ(job.steps[0].verb, "build");
    EXPECT_EQ(job.steps[0].inputs[1], job_folder() / "sub/b.ply");
    EXPECT_EQ(job.steps[2].name, "measure b.ply");
    EXPECT_EQ(job.folder, job_folder() / "out/job");
    // One file of figures cannot be that of two clouds.
    const std::string figures = "[measure]\nper_point = 'p.ply'\n";
    EXPECT_THROW(read_job(write_job("[input]\nfiles = ['a.ply', 'sub/b.ply']\n" + figures)),
                 ConfigError);
    EXPECT_NO_THROW(read_job(write_job("[input]\nfiles = ['a.ply']\n" + figures)));
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
    EXPECT_TRUE(has_line(left_out("color = true\n", ""), "colours: no view shows them"));
    EXPECT_FALSE(has_line(left_out("color = true\n", "aovs = ['color']\n"), "colours: "));
    EXPECT_FALSE(has_line(left_out("color = true\n", "aovs = ['all']\n"), "colours: "));
}

TEST(Job, SaysWhatWillBeMissing) {
    const auto missing = [](const std::string& fit, const std::string& view) {
        const Job job = read_job(write_job("[input]\nfiles = ['a.ply']\n[fit]\n" + fit +
                                           "[[view]]\nname = 'v'\n" + view));
        std::string all;
        for (const std::string& reason : job.missing) all += reason + "\n";
        EXPECT_EQ(explanation_of(job).find("will be missing") != std::string::npos, !all.empty());
        return all;
    };
    const std::string drawing = "lines = ['contour', 'suggestive', 'crest', 'crease']\n";
    EXPECT_EQ(missing("degree = 3\nsharp = 'on'\n", drawing), "");
    EXPECT_EQ(missing("degree = 2\n", drawing),
              "view v: crest lines: they need degree = 3 in [fit]\n"
              "view v: crease lines: they need sharp surfels: sharp = \"on\" in [fit]\n");
    EXPECT_EQ(missing("degree = 1\nsharp = 'on'\n", drawing),
              "view v: suggestive lines: they need degree = 2 in [fit]\n"
              "view v: crest lines: they need degree = 3 in [fit]\n");
    const std::string all = missing("degree = 2\n", "aovs = ['all']\n");
    for (const char* aov :
         {"e1, e2, dk1_dt2, dk2_dt1 of aov all", "color of", "ao of", "truth_distance of"})
        EXPECT_NE(all.find(aov), std::string::npos) << aov << all;
}

TEST(Job, IsChangedBySettings) {
    const fs::path file = write_job(kDemo);
    const Job job = read_job(
        file, {"fit.degree=1", "fit.t_mdl=0.02", "render.size=64x64", "input.scan.noise=0"});
    EXPECT_TRUE(has(job.steps[0], "--noise=0"));
    EXPECT_TRUE(has(job.steps[1], "--degree=1"));
    EXPECT_TRUE(has(job.steps[1], "--t-mdl=0.02"));
    EXPECT_TRUE(has(job.steps[3], "--size=64x64"));
    for (const auto& [setting, message] :
         {std::pair{"degree=1", "expected TABLE.KEY=VALUE"},
          std::pair{"fit.degre=1", "did you mean 'degree'"},
          std::pair{"fit.degree=9", "--set: degree: expected"},
          std::pair{"view.size=3x3", "is a list"}, std::pair{"ftt.degree=1", "did you mean 'fit'"}})
        try {
            read_job(file, {setting});
            ADD_FAILURE() << setting << " was accepted";
        } catch (const ConfigError& error) {
            EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
        }
}

TEST(Job, RefusesUnknownTablesAndKeysWithTheirLine) {
    const std::string start = "[input]\nfiles = ['a.ply']\n";
    const std::pair<const char*, const char*> cases[] = {
        {"[ftt]\n", ":3: unknown table [ftt] (did you mean 'fit'?)"},
        {"[fit]\ndegre = 2\n", ":4: unknown key 'degre' (did you mean 'degree'?)"},
        {"[fit]\noutput = 'm.slim'\n", ":4: unknown key 'output'"},
        {"[fit]\ndegree = 9\n", ":4: degree: expected one of 1, 2, 3, auto; found '9'"},
        {"[[view]]\ncamra = 'front'\n", ":4: unknown key 'camra' (did you mean 'camera'?)"},
        {"[[view]]\naovs = ['men']\n", ""},
        {"[[view]]\nname = 'a'\nsize = '64'\n", ":5: size: "},
        {"[render]\nsize = '0x3'\n", ":4: size: "},
        {"[render]\nsize = '9x9'\n[[view]]\ncamera = 'fromt'\n", ":6: camera: "},
        {"[[view]]\ncamera = '0,0,1,0,0,1'\n", ":4: camera: "},
        {"[[view]]\nbackground = 'pink'\n", ":4: background: "},
        {"[output]\ndirr = 'x'\n", ":4: unknown key 'dirr' (did you mean 'dir'?)"},
        {"[[view]]\nname = 'a'\n[[view]]\nname = 'a'\n", ":5: a second view of the name 'a'"},
        {"[fit.more]\n", "unknown table [more]"},
        {"[[view]]\nlines = ['crease']\n", "expected sharp = \"on\" in [fit]"},
        {"[input.scan]\nshape = 'torus'\n", "expected either files or a scan"},
    };
    for (const auto& [text, message] : cases) {
        SCOPED_TRACE(text);
        const std::string found = refusal(start + text);
        EXPECT_NE(found, "");
        EXPECT_NE(found.find(message), std::string::npos) << found;
        EXPECT_TRUE(found.starts_with(job_folder().string())) << found;
    }
    EXPECT_EQ(refusal(start + "[fit]\nsharp = 'on'\n[[view]]\nlines = ['crease']\n"), "");
    EXPECT_NE(refusal("[fit]\ndegree = 2\n").find("no [input]"), std::string::npos);
    EXPECT_NE(refusal("degree = 2\n" + start).find(":1: unknown key 'degree'"), std::string::npos);
}

}  // namespace
}  // namespace slim::test
