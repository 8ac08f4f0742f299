#pragma once

#include "pipeline/stage.h"
#include "slim/base/vec.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace slim {

/// The virtual scanner's options.
struct ScanConfig {
    std::string shape;
    std::string output;
    std::uint64_t points = 500'000;
    double noise = 0;
    std::string noise_model = "ray";
    int stations = 8;
    double outliers = 0;
    double dropout = 0.5;
    std::uint64_t seed = 1;
    std::vector<double> offset;
    bool normals = true;
    std::string pattern = "scan";
    bool ascii = false;

    template <class Visitor>
    void visit(Visitor&& field) {
        field.positional("shape", shape, "what to scan",
                         {"plane", "sphere", "torus", "ellipsoid", "cyclide", "cylinder", "cone",
                          "monkey", "bumpy", "sculpture"});
        field.output("output", output, "cloud to write (.ply); truth and sensors go beside it");
        field("points", points, "number of points", 1, 1e10);
        field("noise", noise, "standard deviation of the noise, over the diagonal L", 0, 0.1);
        field.choice("noise_model", noise_model, "noise along the ray, or per coordinate",
                     {"ray", "isotropic"});
        field("stations", stations, "scanner positions around the shape (pattern scan)", 1, 1000);
        field("outliers", outliers, "share of the points with a random range", 0, 1);
        field("dropout", dropout,
              "share of the returns lost at grazing incidence, falling to none face on "
              "(pattern scan)",
              0, 1);
        field("seed", seed, "of all random numbers");
        field("offset", offset, "x,y,z added to all positions, which are then written as double");
        field("normals", normals, "write the scanner's own normals");
        field.choice("pattern", pattern,
                     "scan lines from stations, or area-uniform points with exact normals",
                     {"scan", "uniform"});
        field("ascii", ascii, "write the PLY as text");
    }
};

/// --offset. ConfigError unless it is three finite numbers of sense.
Vec3d scan_offset(const ScanConfig& config);

/// All that can be told of the options before a scan but the output's name: readers of jobs ask,
/// too. ConfigError with the key.
void check_scan_options(const ScanConfig& config);

/// `cloud.ply` -> `cloud.scans.json`: the sensor of each scan id.
std::string scans_path(const std::string& cloud_path);

/// Scans and writes the cloud (property `scan`; a `comment slim sensor ID X Y Z` for each station),
/// its truth (formats/truth_file.h) and the stations' positions (scans_path). With an offset the
/// coordinates, sensors included, are absolute and double.
///
/// returns  points, outliers, rays, sigma, spacing (model units), diagonal, stations
/// throws   ConfigError: an output not named .ply, an offset that is not three finite numbers, an
///          option that plays no part in this pattern;
///          IoError as AtomicFile
/// cost     memory for about a million rays, whatever the number of points
nlohmann::json run_scan(const ScanConfig& config, StageContext& context);

}  // namespace slim
