#include "pipeline/scan_stage.h"

#include "formats/extension.h"
#include "formats/ply_writer.h"
#include "formats/truth_file.h"
#include "pipeline/json_text.h"
#include "pipeline/manifest.h"
#include "slim/base/error.h"
#include "slim/scanner/scan.h"
#include "slim/scanner/station.h"

#include <fmt/format.h>

#include <cmath>

namespace slim {
namespace {

ScanSettings settings_of(const ScanConfig& config) {
    ScanSettings settings;
    settings.n_points = config.points;
    settings.n_stations = config.stations;
    settings.noise = config.noise;
    settings.noise_model = config.noise_model == "ray" ? NoiseModel::ray : NoiseModel::isotropic;
    settings.outliers = config.outliers;
    settings.dropout = config.dropout;
    settings.seed = config.seed;
    return settings;
}

void check_output(const std::string& output) {
    if (lower_extension(output) != ".ply")
        throw ConfigError({.file = output,
                           .problem = "the scanner writes PLY",
                           .expected = "a name ending in .ply"});
}

/// Known before the scan: the header comes first.
std::vector<Vec3d> sensors_of(const ScanConfig& config, const Shape& shape, const Vec3d& offset) {
    std::vector<Vec3d> sensors;
    if (config.pattern == "uniform") return sensors;
    for (const Station& s : stations_around(shape.bounds, config.stations))
        sensors.push_back(s.position + offset);
    return sensors;
}

PlyLayout layout_of(const ScanConfig& config, const std::vector<Vec3d>& sensors) {
    PlyLayout layout;
    layout.double_positions = !config.offset.empty();
    layout.normals = config.normals;
    layout.scan = !sensors.empty();
    layout.ascii = config.ascii;
    layout.comments.push_back(fmt::format("slim scan of {}, seed {}", config.shape, config.seed));
    for (std::size_t id = 0; id < sensors.size(); ++id)
        layout.comments.push_back(fmt::format("slim sensor {} {} {} {}", id, sensors[id].x,
                                              sensors[id].y, sensors[id].z));
    return layout;
}

/// Cloud and truth, in step.
class CloudSink {
public:
    CloudSink(const ScanConfig& config, const std::vector<Vec3d>& sensors, const Vec3d& offset)
        : cloud_(config.output, layout_of(config, sensors)),
          truth_(truth_path(config.output)),
          offset_(offset) {}

    void write(const ScanBlock& block) {
        positions_.assign(block.positions.begin(), block.positions.end());
        for (Vec3d& p : positions_) p += offset_;
        cloud_.write({positions_, block.normals, {}, block.scan_ids, {}});
        truths_.clear();
        for (const SurfacePoint& t : block.truth) truths_.push_back({t.normal, t.k1, t.k2});
        truth_.write(truths_);
    }

    /// The cloud last: where it is, its truth is.
    void commit() {
        truth_.commit();
        cloud_.commit();
    }

private:
    PlyWriter cloud_;
    TruthWriter truth_;
    Vec3d offset_;
    std::vector<Vec3d> positions_;
    std::vector<PointTruth> truths_;
};

void write_sensors(const std::string& path, const std::vector<Vec3d>& sensors) {
    nlohmann::json scans = nlohmann::json::array();
    for (std::size_t id = 0; id < sensors.size(); ++id)
        scans.push_back(
            {{"id", id}, {"position", {sensors[id].x, sensors[id].y, sensors[id].z}}});
    write_file_atomically(path, text_of({{"scans", scans}}, 2) + "\n");
}

}  // namespace

std::string scans_path(const std::string& cloud_path) {
    const std::size_t suffix = lower_extension(cloud_path) == ".ply" ? 4 : 0;
    return cloud_path.substr(0, cloud_path.size() - suffix) + ".scans.json";
}

nlohmann::json run_scan(const ScanConfig& config, StageContext& context) {
    check_output(config.output);
    check_scan_options(config);
    const Vec3d offset = scan_offset(config);
    const Shape& shape = find_shape(config.shape);
    Stamp stamp(context, manifest_path(config.output));
    stamp.outputs({config.output, truth_path(config.output), scans_path(config.output)});
    if (auto result = stamp.up_to_date()) return *result;

    const std::vector<Vec3d> sensors = sensors_of(config, shape, offset);
    const ScanSettings settings = settings_of(config);
    CloudSink sink(config, sensors, offset);
    const auto scan = config.pattern == "uniform" ? sample_uniformly : scan_shape;
    const ScanSummary summary =
        scan(shape, settings, [&](const ScanBlock& b) { sink.write(b); }, context.reporter);
    write_sensors(scans_path(config.output), sensors);
    sink.commit();

    return stamp.commit({{"points", summary.points},
                         {"outliers", summary.outliers},
                         {"rays", summary.rays},
                         {"sigma", summary.sigma},
                         {"spacing", summary.spacing},
                         {"diagonal", shape.bounds.diagonal()},
                         {"stations", sensors.size()}});
}

}  // namespace slim
