#include "pipeline/build/sensors.h"

#include "formats/extension.h"
#include "pipeline/json_text.h"
#include "slim/base/error.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>

namespace slim {
namespace {

constexpr double kFar = 1e4;  // diagonals: where a direction's scanner stands

constexpr std::int64_t kMostScans = 65536;

/// The number of a scan in the job, from its entry.
std::size_t scan_of(const nlohmann::json& entry, std::uint32_t first_scan,
                    const std::string& path) {
    const nlohmann::json& id = entry.at("id");
    // Larger ones would wrap around to another scan's.
    const bool fits = id.is_number_integer() && id >= 0 && id < kMostScans;
    if (!fits || first_scan + id.get<std::int64_t>() >= kMostScans)
        throw FormatError(fmt::format("{}: scan {}: expected an id from 0 to {}", path, text_of(id),
                                      kMostScans - 1 - first_scan));
    return first_scan + id.get<std::size_t>();
}

/// Where the entry's sensor stands, frame of the job.
Vec3d sensor_of(const nlohmann::json& entry, const SlicePlan& plan, const std::string& path) {
    // A scanner that is far away, or known by its view only, is a direction: object to scanner.
    const bool far = entry.contains("direction");
    const char* key = far ? "direction" : "position";
    const auto fail = [&](const char* expected) {
        throw FormatError(fmt::format("{}: scan {}: {} {}: expected {}", path,
                                      text_of(entry.at("id")), key, text_of(entry.at(key)),
                                      expected));
    };
    const auto p = entry.at(key).get<std::vector<double>>();
    if (p.size() != 3) fail("3 numbers");
    const Vec3d v{p[0], p[1], p[2]};
    if (!is_finite(v)) fail("finite numbers");
    if (!far) return v - plan.origin;
    const double most = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    if (!(most > 0)) fail("one that is not zero");
    return plan.bounds.center() + normalized(v / most) * (kFar * plan.diagonal);
}

/// Adds the positions of one file, whose scan numbers start at `first_scan` in the job.
void add_sensors(const std::string& path, std::uint32_t first_scan, const SlicePlan& plan,
                 std::vector<Vec3d>& out) {
    if (std::filesystem::is_directory(path))
        throw IoError(path + ": is a folder; expected a file of sensors (JSON)");
    std::ifstream file(path);
    if (!file) throw IoError(fmt::format("{}: cannot be opened", path));
    try {
        const auto scans = json_from(file);  // named: it must outlive the loop
        for (const auto& scan : scans.at("scans")) {
            const std::size_t id = scan_of(scan, first_scan, path);
            constexpr double nan = std::numeric_limits<double>::quiet_NaN();
            if (out.size() <= id) out.resize(id + 1, Vec3d{nan, nan, nan});
            out[id] = sensor_of(scan, plan, path);
        }
    } catch (const nlohmann::json::exception& e) {
        throw FormatError(
            fmt::format("{}: expected {{\"scans\": [{{\"id\": 0, \"position\": [x, y, z]}}, ...]}} "
                        "or a \"direction\": {}",
                        path, e.what()));
    }
}

}  // namespace

std::string scans_json_path(const std::string& cloud_path) {
    std::filesystem::path path(cloud_path);
    if (lower_extension(cloud_path) == ".gz") path.replace_extension();
    return path.replace_extension(".scans.json").string();
}

std::vector<Vec3d> read_sensors(const std::string& sensors_file, const SlicePlan& plan) {
    std::vector<Vec3d> out;
    if (!sensors_file.empty()) {
        add_sensors(sensors_file, 0, plan, out);
        return out;
    }
    for (const PlanInput& input : plan.inputs) {
        const std::string path = scans_json_path(input.path);
        if (std::filesystem::exists(path)) add_sensors(path, input.first_scan, plan, out);
    }
    return out;
}

}  // namespace slim
