#pragma once

#include "slim/scanner/scan.h"

#include <cstdint>
#include <string_view>

namespace slim::test {

/// A cloud with its truth, one entry per point in every array.
using Cloud = ScanBlock;

inline void append(Cloud& cloud, const ScanBlock& block) {
    cloud.positions.insert(cloud.positions.end(), block.positions.begin(), block.positions.end());
    cloud.normals.insert(cloud.normals.end(), block.normals.begin(), block.normals.end());
    cloud.truth.insert(cloud.truth.end(), block.truth.begin(), block.truth.end());
    cloud.scan_ids.insert(cloud.scan_ids.end(), block.scan_ids.begin(), block.scan_ids.end());
}

/// n area-uniform points of a shape with exact normals; `noise` is the standard deviation per
/// coordinate over the diagonal of the shape's bounds, the truth that of the foot point.
inline Cloud sampled(std::string_view shape, std::uint64_t n, std::uint64_t seed = 1,
                     double noise = 0) {
    ScanSettings settings;
    settings.n_points = n;
    settings.seed = seed;
    settings.noise = noise;
    settings.noise_model = NoiseModel::isotropic;
    Cloud cloud;
    Reporter silent;
    sample_uniformly(find_shape(shape), settings, [&](const ScanBlock& b) { append(cloud, b); },
                     silent);
    return cloud;
}

/// What scan_shape delivers, in one piece.
inline Cloud scanned(std::string_view shape, const ScanSettings& settings,
                     ScanSummary* summary = nullptr) {
    Cloud cloud;
    Reporter silent;
    const ScanSummary s = scan_shape(find_shape(shape), settings,
                                     [&](const ScanBlock& b) { append(cloud, b); }, silent);
    if (summary) *summary = s;
    return cloud;
}

/// Keeps the points for which keep(position) holds: holes.
template <class Keep>
Cloud filtered(const Cloud& cloud, Keep&& keep) {
    Cloud out;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        if (!keep(cloud.positions[i])) continue;
        out.positions.push_back(cloud.positions[i]);
        out.normals.push_back(cloud.normals[i]);
        out.truth.push_back(cloud.truth[i]);
        out.scan_ids.push_back(cloud.scan_ids[i]);
    }
    return out;
}

}  // namespace slim::test
