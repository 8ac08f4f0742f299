#include "pipeline/job/job.h"
#include "pipeline/job/job_steps.h"
#include "pipeline/render/render_check.h"
#include "tests/pipeline/job/job_support.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace slim::test {
namespace {

const std::string kInput = "[input]\nfiles = [\"a.ply\"]\n";

/// What reading a job says whose lines 3 and on are these.
std::string said_of(const std::string& tables) { return refusal(kInput + tables); }

struct Mistake {
    const char* view;  ///< that begins at line 3
    int line;
    const char* said;
};

// What slim-render alone can tell once there is a model is told before there is one.
TEST(JobChecks, AViewThatCannotBeDrawnIsRefusedWithItsLine) {
    const Mistake mistakes[] = {
        {"size = '9x9'\nscale_bar = true", 5, "scale_bar: a perspective picture has no one scale"},
        {"size = '100x100'\ncrop = '0,0,500,5'", 5, "crop: expected x,y,w,h inside the picture"},
        {"size = '100x100'\ntile = '9/3'", 5, "tile: expected i/n"},
        {"size = '100x100'\ntile = '200/300'", 5, "tile: expected i/n"},
        {"tile = '1/2'\ncrop = '0,0,5,5'", 5, "crop and"},
        {"aovs = ['mean']\nsame_range = ['bogus']", 5, "same_range: expected named cameras"},
        {"aovs = ['mean']\nrange = ['bogus=1']", 5, "range: expected"},
        {"aovs = ['truth_distance']", 4, "aov truth_distance needs a shape"},
        {"truth_shape = 'blob'\naovs = ['truth_distance']", 4, "truth_shape: expected one of"},
        {"aovs = ['truth_distance']\ntruth_shape = 'torus'\noffset = '1,2'", 6, "offset: expected"},
        {"aovs = ['hillshade']\nsun = [1, 100]", 5, "sun: expected two angles"},
        {"aovs = ['hillshade']\ncontours = 'x'", 5, "contours: expected auto"},
        {"turntable = 4\nlines = ['contour']\nlines_ply = 'a.ply'", 6, "lines_ply is for one"},
        {"mode = 'raytrace'\nground = true\nground_color = 'x'", 6, "ground_color: expected"},
        {"mode = 'raytrace'\nmaterial = 'mirror=0; mirror=0'", 5, "material: expected at most one"},
        {"frames = 3", 4, "frames is for a"},
    };
    for (const Mistake& m : mistakes) {
        SCOPED_TRACE(m.view);
        const std::string said = said_of(std::string("[[view]]\n") + m.view + "\n");
        const std::string place = "job.toml:" + std::to_string(m.line) + ": ";
        EXPECT_NE(said.find(place + m.said), std::string::npos) << said;
    }
}

// An option of all views that one of them cannot take: said where it stands, with the view.
TEST(JobChecks, AnOptionOfAllViewsIsRefusedWithItsOwnLineAndTheView) {
    const std::string said =
        said_of("[render]\nscale_bar = true\n[[view]]\northo = true\n[[view]]\ncamera = 'iso'\n");
    EXPECT_NE(said.find("job.toml:4: scale_bar"), std::string::npos) << said;
    EXPECT_NE(said.find("(view iso)"), std::string::npos) << said;
    // pictures along a path: their number may be of all views, the path a view's own
    EXPECT_EQ(said_of("[render]\nframes = 3\n[[view]]\npath = 'front; iso'\n"), "");
}

TEST(JobChecks, WhatTheOtherVerbsRefuseIsRefusedWithItsLine) {
    const Mistake mistakes[] = {
        {"[fit]\nmemory = '1MiB'", 4, "memory: expected at least 64 MiB"},
        {"[fit]\ndegree = 2\nmemory = 'x'", 5, "memory: expected a number"},
        {"[fit]\ndegree = 'auto'\nradius_rule = 'windows'", 5, "radius_rule windows"},
        {"[fit]\nnormals = 'keep'\nsensors = 'a.json'", 5, "sensors: turn estimated normals"},
        {"[measure]\nsamples = 7", 4, "samples are those of the model's surface"},
        {"[measure]\nper_point = 'x.xyz'", 3, "x.xyz: the figures of points are a PLY"},
    };
    for (const Mistake& m : mistakes) {
        SCOPED_TRACE(m.view);
        const std::string said = said_of(std::string(m.view) + "\n");
        const std::string place = "job.toml:" + std::to_string(m.line) + ": ";
        EXPECT_NE(said.find(place), std::string::npos) << said;
        EXPECT_NE(said.find(m.said), std::string::npos) << said;
    }
    const std::string scan =
        refusal("[input.scan]\nshape = 'torus'\npattern = 'uniform'\nstations = 3\n");
    EXPECT_NE(scan.find("job.toml:4: stations"), std::string::npos) << scan;
}

// Files that are read later must be there at the start.
TEST(JobChecks, FilesOfMeasuresAndSensorsAreInputs) {
    const auto missing = [](const std::string& tables) {
        const std::filesystem::path cloud = job_folder() / "a.ply";
        std::ofstream(cloud) << "ply\n";
        try {
            require_inputs(read_job(write_job(kInput + tables)));
            return std::string();
        } catch (const IoError& error) {
            return std::string(error.what());
        }
    };
    const std::string truth = missing("[measure]\ntruth = 'nope'\n");
    EXPECT_NE(truth.find("job.toml:3: measure: "), std::string::npos) << truth;
    EXPECT_NE(truth.find("nope: no such file"), std::string::npos) << truth;
    EXPECT_NE(missing("[fit]\nsensors = 'none.json'\n").find("none.json"), std::string::npos);
    EXPECT_EQ(missing("[measure]\n"), "");
}

// The same function refuses a command line.
TEST(JobChecks, TheRendererAsksTheSame) {
    RenderConfig config;
    EXPECT_NO_THROW(check_options(config));
    config.scale_bar = true;
    EXPECT_THROW(check_options(config), ConfigError);
    config.ortho = true;
    EXPECT_NO_THROW(check_options(config));
    config.size = "100x100", config.crop = "0,0,500,5";
    EXPECT_THROW(check_options(config), ConfigError);
}

}  // namespace
}  // namespace slim::test
