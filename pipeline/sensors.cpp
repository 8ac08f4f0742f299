#include "pipeline/sensors.h"

#include "formats/extension.h"
#include "pipeline/json_text.h"
#include "slim/base/error.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

namespace slim {
namespace {

constexpr double kFar = 1e4;  // diagonals: where a direction's scanner stands

/// Adds the positions of one file, whose scan numbers start at `first_scan` in the job.
void add_sensors(const std::string& path, std::uint32_t first_scan, const SlicePlan& plan,
                 std::vector<Vec3d>& out) {
    std::ifstream file(path);
    if (!file) throw IoError(fmt::format("{}: cannot be opened", path));
    try {
        const auto scans = json_from(file);  // named: it must outlive the loop
        for (const auto& scan : scans.at("scans")) {
            const std::size_t id = first_scan + scan.at("id").get<std::uint32_t>();
            // A scanner that is far away, or known by its view only, is a direction: object to
            // scanner.
            const bool far = scan.contains("direction");
            const auto p = scan.at(far ? "direction" : "position").get<std::vector<double>>();
            if (p.size() != 3 || id > 65535)
                throw FormatError(fmt::format(
                    "{}: scan {}: expected an id below 65536 and a position of 3 numbers", path, id));
            constexpr double nan = std::numeric_limits<double>::quiet_NaN();
            if (out.size() <= id) out.resize(id + 1, Vec3d{nan, nan, nan});
            const Vec3d v{p[0], p[1], p[2]};
            out[id] = far ? plan.bounds.center() + normalized(v) * (kFar * plan.diagonal)
                          : v - plan.origin;
        }
    } catch (const nlohmann::json::exception& e) {
        throw FormatError(fmt::format(
            "{}: expected {{\"scans\": [{{\"id\": 0, \"position\": [x, y, z]}}, ...]}} or a \"direction\": {}", path,
            e.what()));
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
