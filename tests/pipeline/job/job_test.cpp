#include "pipeline/job/job.h"

#include "pipeline/job/job_source.h"
#include "tests/pipeline/job/job_support.h"

#include <gtest/gtest.h>

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

TEST(Job, ATitleIsAString) {
    const std::string input = "[input]\nfiles = ['a.ply']\n[output]\n";
    EXPECT_EQ(read_job(write_job(input + "title = '3'\n")).title, "3");
    try {
        read_job(write_job(input + "title = 3\n"));
        ADD_FAILURE();
    } catch (const ConfigError& e) {
        EXPECT_NE(std::string(e.what()).find(":4: title: expected a string, found 3"),
                  std::string::npos)
            << e.what();
    }
    EXPECT_EQ(read_job(write_job(input), {"output.title=2024"}).title, "2024");
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
          std::pair{"input.files=[\"a.ply\", \"b.ply\"", "not an array: expected [\"a\", \"b\"]"},
          std::pair{"render.same_range= [front]", "not an array"},
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
        {"[[view]]\naovs = ['men']\n", ":4: aovs: "},
        {"[[view]]\n[output]\naovs = ['men']\n", ":5: aovs: "},
        {"[[view]]\nsize = '9x9'\nname = 'a/b'\n", ":5: name: "},
        {"[[view]]\nsize = '9x9'\nao = true\n", ":5: ao needs rays"},
        {"[[view]]\nsize = '9x9'\naovs = ['ao']\n", ":5: aov ao needs rays"},
        {"[render]\nground = true\n[[view]]\nsize = '9x9'\n", ":4: ground needs rays"},
        {"[[view]]\nsize = '9x9'\nlines = ['crest']\n[fit]\ndegree = 2\n", ":5: lines crest"},
        {"[[view]]\nsize = '9x9'\nshares = 99\n", ":5: shares: expected at most 9"},
        // What a step would refuse after the build.
        {"[[view]]\nsize = '9x9'\nscale_bar = true\n", ":5: scale_bar: a perspective picture"},
        {"[[view]]\nsize = '9x9'\naovs = ['truth_distance']\n", ":5: aov truth_distance needs a"},
        {"[[view]]\naovs = ['truth_distance']\ntruth_shape = 'tours'\n", ":5: truth_shape: "},
        {"[render]\naovs = 'mean'\n[[view]]\n", ":4: unknown key 'aovs'"},
        {"[[view]]\naovs = ['mean']\nrange = 'mean=3:1'\n", ":5: range: expected A > 0"},
        {"[[view]]\naovs = ['mean']\nsame_range = 'fornt'\n", "(did you mean 'front'?)"},
        {"[[view]]\naovs = ['hillshade']\nsun = [1, 400]\n", ":5: sun: expected two angles"},
        {"[[view]]\naovs = ['hillshade']\ncontours = 'x'\n", ":5: contours: expected auto"},
        {"[[view]]\nsize = '9x9'\ncrop = '0,0,9,10'\n", ":5: crop: expected x,y,w,h inside"},
        {"[render]\ntile = '9/8'\n[[view]]\nsize = '9x9'\n", ":4: tile: expected i/n"},
        {"[[view]]\nlines = 'contour'\nlines_ply = 'a.ply'\nturntable = 2\n",
         ":5: lines_ply is for one picture"},
        {"[render]\nlines = 'crest'\n[fit]\ndegree = 2\n[[view]]\n", ":4: lines crest"},
        {"[[view]]\nname = 'a'\nsize = '64'\n", ":5: size: "},
        {"[render]\nsize = '0x3'\n", ":4: size: "},
        {"[render]\nsize = '9x9'\n[[view]]\ncamera = 'fromt'\n", ":6: camera: "},
        {"[[view]]\ncamera = '0,0,1,0,0,1'\n", ":4: camera: "},
        {"[[view]]\nbackground = 'pink'\n", ":4: background: "},
        {"[output]\ndirr = 'x'\n", ":4: unknown key 'dirr' (did you mean 'dir'?)"},
        {"[[view]]\nname = 'a'\n[[view]]\nname = 'a'\n", ":5: a second view of the name 'a'"},
        {"[output]\nfolder = 'x'\n",
         ":4: unknown key 'folder': expected one of dir, title, aovs, html"},
        {"[render]\nqqqqqqqqq = 'x'\n", ":4: unknown key 'qqqqqqqqq': expected one of shares, "},
        {"[[view]]\nqqqqqqqqq = 'x'\n", ":4: unknown key 'qqqqqqqqq': expected one of name, "},
        {"[fit]\nqqqqqqqqq = 'x'\n", ":4: unknown key 'qqqqqqqqq': expected one of "},
        {"[measure]\nqqqqqqqqq = 'x'\n", ":4: unknown key 'qqqqqqqqq': expected one of "},
        {"qqqqqqqqq = 'x'\n", ":3: unknown key 'qqqqqqqqq': expected files"},
        {"[qqqqqqqqq]\n", ":3: unknown table [qqqqqqqqq]: expected input, fit, render, light, "},
        {"[fit.more]\n", ":3: unknown table [more]: expected keys alone within [fit]"},
        {"[fit]\nsharp = 'off'\n[[view]]\nlines = ['crease']\n",
         "expected sharp = \"on\" in [fit]"},
        {"[input.scan]\nshape = 'torus'\n", "expected either files or a scan"},
    };
    for (const auto& [text, message] : cases) {
        SCOPED_TRACE(text);
        const std::string found = refusal(start + text);
        EXPECT_NE(found, "");
        EXPECT_NE(found.find(message), std::string::npos) << found;
        EXPECT_TRUE(found.starts_with(job_folder().string())) << found;
    }
    EXPECT_EQ(refusal(start + "[[view]]\nlines = ['crease']\n"), "");  // the points decide
    EXPECT_EQ(refusal(start + "[fit]\nsharp = 'on'\n[[view]]\nlines = ['crease']\n"), "");
    EXPECT_NE(refusal("[fit]\ndegree = 2\n").find("no [input]"), std::string::npos);
    EXPECT_NE(refusal("degree = 2\n" + start).find(":1: unknown key 'degree'"), std::string::npos);
}

}  // namespace
}  // namespace slim::test
