#pragma once

#include "formats/ply_writer.h"
#include "formats/truth_file.h"
#include "pipeline/build/build_stage.h"
#include "pipeline/build/fit_stage.h"
#include "pipeline/build/normals_stage.h"
#include "pipeline/build/slice_stage.h"
#include "pipeline/build/tree_stage.h"
#include "pipeline/measure/measure_stage.h"
#include "tests/formats/format_support.h"
#include "tests/support/shapes.h"

#include <string>
#include <vector>

namespace slim::test {

/// Keeps what is said.
class Listener : public Reporter {
public:
    void info(const std::string& text) override { infos.push_back(text); }
    void warn(const std::string& text) override { warnings.push_back(text); }
    std::vector<std::string> infos, warnings;
};

/// Runs one stage as its main would.
template <class Config, class Run>
nlohmann::json run_as(const char* name, const Config& config, Run run, Reporter& reporter,
                      bool force = false) {
    const StageContext parent{reporter, 1, force, "", "", "", "", {}};
    StageContext context = for_stage(parent, name, config);
    return run(config, context);
}

/// A folder with clouds, and the stages run in it.
class FitStages : public testing::Test {
protected:
    std::string file(const std::string& name) const { return folder_.file(name); }

    /// Writes a cloud (doubles), with its normals unless told otherwise, and its truth beside it.
    std::string write(const Cloud& cloud, const std::string& name, bool normals = true) const {
        PlyLayout layout;
        layout.double_positions = true;
        layout.normals = normals;
        layout.scan = true;
        PlyWriter writer(file(name), layout);
        writer.write({cloud.positions, cloud.normals, {}, cloud.scan_ids, {}});
        writer.commit();
        TruthWriter truth(truth_path(file(name)));
        std::vector<PointTruth> values;
        for (const SurfacePoint& t : cloud.truth) values.push_back({t.normal, t.k1, t.k2});
        truth.write(values);
        truth.commit();
        return file(name);
    }
    BuildConfig build_config(const std::string& cloud, const std::string& model) const {
        BuildConfig c;
        c.inputs = {cloud};
        c.output = file(model);
        return c;
    }
    nlohmann::json build(const BuildConfig& c) { return run_as("build", c, run_build, listener_); }
    nlohmann::json measure(const std::string& model, const std::string& cloud) {
        MeasureConfig c;
        c.model = model;
        c.cloud = cloud;
        return run_as("measure", c, run_measure, listener_);
    }
    void slice(const std::string& cloud, int slices, const std::string& memory = "1GiB") {
        SliceConfig c;
        c.memory = memory;
        c.inputs = {cloud};
        c.work = file("work");
        c.slices = slices;
        run_as("slice", c, run_slice, listener_);
    }
    nlohmann::json normals(NormalsConfig c = {}) {
        c.work = file("work");
        return run_as("normals", c, run_normals, listener_);
    }
    nlohmann::json fit(FitConfig c = {}) {
        c.work = file("work");
        return run_as("fit", c, run_fit, listener_);
    }
    nlohmann::json tree(const std::string& model) {
        TreeConfig c;
        c.work = file("work");
        c.output = file(model);
        return run_as("tree", c, run_tree, listener_);
    }
    /// The exit code of the slim::Error that the call ends with.
    template <class Call>
    ExitCode code_of(Call&& call) {
        try {
            call();
            return ExitCode::ok;
        } catch (const Error& error) {
            message_ = error.what();
            return error.code();
        }
    }

    TempFolder folder_;
    Listener listener_;
    std::string message_;
};

}  // namespace slim::test
