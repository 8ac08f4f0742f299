#include "pipeline/build/sensors.h"

#include "formats/extension.h"
#include "pipeline/json_text.h"
#include "pipeline/manifest.h"
#include "slim/base/error.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <utility>

namespace slim {
namespace {

constexpr double kFar = 1e4;  // diagonals: where a direction's scanner stands

constexpr std::int64_t kMostScans = 65536;

constexpr const char* kForm =
    "{\"scans\": [{\"id\": 0, \"position\": [x, y, z]}, ...]}, or a \"direction\"";

/// What is wrong with a file of sensors, and where in it.
[[noreturn]] void refuse(const std::string& path, std::string place, std::string expected,
                         std::string found) {
    throw FormatError(Fault{.file = path,
                            .problem = std::move(place),
                            .expected = std::move(expected),
                            .found = std::move(found)});
}

std::string short_text(const nlohmann::json& value) {
    constexpr std::size_t kMost = 60;
    const std::string text = text_of(value);
    return text.size() > kMost ? text.substr(0, kMost) + "..." : text;
}

/// The number of a scan in the job, from its entry.
std::size_t scan_of(const nlohmann::json& entry, std::uint32_t first_scan,
                    const std::string& path) {
    const nlohmann::json& id = entry.at("id");
    // Larger ones would wrap around to another scan's.
    const bool fits = id.is_number_integer() && id >= 0 && id < kMostScans;
    if (!fits || first_scan + id.get<std::int64_t>() >= kMostScans)
        refuse(path, "scan " + text_of(id),
               fmt::format("an id from 0 to {}", kMostScans - 1 - first_scan), text_of(id));
    return first_scan + id.get<std::size_t>();
}

/// Where the entry's sensor stands, frame of the job.
Vec3d sensor_of(const nlohmann::json& entry, const SlicePlan& plan, const std::string& path) {
    // A scanner that is far away, or known by its view only, is a direction: object to scanner.
    const bool far = entry.contains("direction");
    const char* key = far ? "direction" : "position";
    const nlohmann::json& p = entry.at(key);
    const auto fail = [&](const char* expected) {
        refuse(path, fmt::format("scan {}: {}", text_of(entry.at("id")), key), expected,
               short_text(p));
    };
    const auto is_number = [](const nlohmann::json& item) { return item.is_number(); };
    if (!p.is_array() || p.size() != 3 || !std::all_of(p.begin(), p.end(), is_number))
        fail("3 numbers");
    const Vec3d v{p[0].get<double>(), p[1].get<double>(), p[2].get<double>()};
    if (!is_finite(v)) fail("finite numbers");
    if (!far) return v - plan.origin;
    const double most = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    if (!(most > 0)) fail("one that is not zero");
    return plan.bounds.center() + normalized(v / most) * (kFar * plan.diagonal);
}

/// An entry has an id and a place.
void check_entry(const nlohmann::json& entry, std::size_t number, const std::string& path) {
    if (!entry.is_object())
        refuse(path, fmt::format("entry {} of scans", number), "an object", short_text(entry));
    const bool placed = entry.contains("position") || entry.contains("direction");
    if (!entry.contains("id") || !placed)
        refuse(path, fmt::format("entry {} of scans", number),
               placed ? "an \"id\"" : "a \"position\" or a \"direction\"", short_text(entry));
}

/// Adds the positions of one file, whose scan numbers start at `first_scan` in the job.
void add_sensors(const std::string& path, std::uint32_t first_scan, const SlicePlan& plan,
                 std::vector<Vec3d>& out) {
    if (std::filesystem::is_directory(path))
        throw IoError(path + ": is a folder; expected a file of sensors (JSON)");
    const nlohmann::json file = read_json(path);
    if (!file.is_object() || !file.contains("scans") || !file.at("scans").is_array())
        refuse(path, "", kForm, short_text(file));
    std::size_t number = 0;
    for (const auto& scan : file.at("scans")) {
        check_entry(scan, ++number, path);
        const std::size_t id = scan_of(scan, first_scan, path);
        constexpr double nan = std::numeric_limits<double>::quiet_NaN();
        if (out.size() <= id) out.resize(id + 1, Vec3d{nan, nan, nan});
        out[id] = sensor_of(scan, plan, path);
    }
}

}  // namespace

std::string scans_json_path(const std::string& cloud_path) {
    std::filesystem::path path(cloud_path);
    if (lower_extension(cloud_path) == ".gz") path.replace_extension();
    return path.replace_extension(".scans.json").string();
}

std::string sensors_hash(const std::vector<Vec3d>& sensors) {
    std::string text;
    for (const Vec3d& s : sensors) text += fmt::format("{} {} {}\n", s.x, s.y, s.z);
    return sensors.empty() ? "" : hash_text(text);
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
