#pragma once

#include "slim/fit/noise_variance.h"
#include "tests/slim/fit/fit_support.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace slim::test {

/// All points by the hash of their ids.
inline std::vector<std::uint32_t> samples_of(const PointBlock& block) {
    std::vector<std::uint32_t> samples(block.size());
    std::iota(samples.begin(), samples.end(), 0u);
    std::sort(samples.begin(), samples.end(), [&](std::uint32_t a, std::uint32_t b) {
        return keyed_hash(7, block.id[a]) < keyed_hash(7, block.id[b]);
    });
    return samples;
}

inline PointBlock without_normals(const std::vector<Vec3d>& points) {
    return along_curve(block_of(points, std::vector<Vec3f>(points.size())));
}

/// The noise of a cloud as its points show it, at most so many of them.
inline NoiseVariance measured_noise(const std::vector<Vec3d>& points, std::size_t neighbors = 0,
                                    std::size_t most_samples = 1000000,
                                    std::size_t fewest = kFewestSamples) {
    const PointBlock block = without_normals(points);
    std::vector<std::uint32_t> samples = samples_of(block);
    samples.resize(std::min(samples.size(), most_samples));
    const NearestSearch search(block.position);
    return estimate_noise_variance(search, samples, neighbors, {}, fewest);
}

}  // namespace slim::test
