#include "slim/smooth/cloud_sample.h"

#include "slim/base/check.h"
#include "slim/neighbors/point_pyramid.h"

#include <utility>

namespace slim {

CloudSampler::CloudSampler(std::size_t most, std::uint64_t seed) : most_(most), seed_(seed) {
    SLIM_CHECK(most, >, 0u);
}

void CloudSampler::add(std::span<const Vec3d> positions, std::span<const Vec3f> normals,
                       const Vec3d& origin) {
    if (!normals.empty()) SLIM_CHECK(normals.size(), ==, positions.size());
    PointBlock& p = sample_.points;
    p.position.reserve(most_ + 1), p.id.reserve(most_ + 1);
    if (!normals.empty()) p.normal.reserve(most_ + 1);
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const std::uint64_t id = next_id_++;
        const Vec3d at = positions[i] - origin;
        if (!is_finite(at) || !in_share(seed_, id, sample_.share)) continue;
        p.position.push_back(at), p.id.push_back(id);
        if (!normals.empty()) {
            const Vec3d n = to_double(normals[i]);
            p.normal.push_back(is_finite(n) && sq_length(n) > 0 ? to_float(normalized(n))
                                                                : Vec3f{});
        }
        while (p.size() > most_) thin();
    }
}

CloudSample CloudSampler::take() { return std::exchange(sample_, {}); }

void CloudSampler::thin() {
    PointBlock& p = sample_.points;
    sample_.share /= 2;
    std::size_t n = 0;
    for (std::size_t i = 0; i < p.size(); ++i) {
        if (!in_share(seed_, p.id[i], sample_.share)) continue;
        p.position[n] = p.position[i], p.id[n] = p.id[i];
        if (p.has_normals()) p.normal[n] = p.normal[i];
        ++n;
    }
    p.position.resize(n), p.id.resize(n);
    if (p.has_normals()) p.normal.resize(n);
}

}  // namespace slim
