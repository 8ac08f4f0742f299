#include "formats/face_edges.h"

#include "slim/base/area_vector.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

namespace slim {
namespace {

constexpr double kFlat = 1e-6;  // height over extent of a face that has no normal to speak of

std::vector<std::uint32_t> first_of_place(std::span<const Vec3d> position) {
    const auto key = [&](std::uint32_t i) {  // an order of NaN as well; 0 and -0 are one
        const Vec3d& p = position[i];
        return std::tuple(std::bit_cast<std::uint64_t>(p.x + 0.0),
                          std::bit_cast<std::uint64_t>(p.y + 0.0),
                          std::bit_cast<std::uint64_t>(p.z + 0.0));
    };
    std::vector<std::uint32_t> order(position.size()), out(position.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
        return std::pair(key(i), i) < std::pair(key(j), j);
    });
    for (std::size_t k = 0; k < order.size(); ++k)
        out[order[k]] =
            k > 0 && key(order[k]) == key(order[k - 1]) ? out[order[k - 1]] : order[k];
    return out;
}

double sq_extent(const FaceList& faces, std::size_t f) {
    double most = 0;
    for (const std::uint32_t v : faces[f])
        most = std::max(most, sq_length(faces.position[v] - faces.position[faces[f][0]]));
    return most;
}

}  // namespace

FaceEdges::FaceEdges(const FaceList& faces) : faces_(faces) {
    find_normals();
    const std::vector<std::uint32_t> place = first_of_place(faces.position);
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
        const auto corners = faces[f];
        if (area_[f] == 0) continue;
        for (std::size_t k = 0; k < corners.size(); ++k) {
            const std::uint32_t a = place[corners[k]], b = place[corners[(k + 1) % corners.size()]];
            if (a != b) sides_.push_back({std::min(a, b), std::max(a, b), f, a < b});
        }
    }
    std::sort(sides_.begin(), sides_.end(), [](const Side& s, const Side& t) {
        return std::tuple(s.a, s.b, s.face) < std::tuple(t.a, t.b, t.face);
    });
}

void FaceEdges::find_normals() {
    normal_.resize(faces_.size());
    area_.resize(faces_.size());
    for (std::size_t f = 0; f < faces_.size(); ++f) {
        const Vec3d area = area_vector(faces_.position, faces_[f]);
        const double size = length(area);
        if (!std::isfinite(size) || !(size > kFlat * sq_extent(faces_, f))) continue;
        normal_[f] = area / size, area_[f] = size / 2;
    }
}

double FaceEdges::length_of(const Side& side) const {
    return length(faces_.position[side.b] - faces_.position[side.a]);
}

double FaceEdges::turn(const Side& first, const Side& second) const {
    const Vec3d &n = normal_[first.face],
                m = first.forward == second.forward ? -normal_[second.face] : normal_[second.face];
    return std::atan2(length(cross(n, m)), dot(n, m));
}

double FaceEdges::width(const Side& side) const {
    return (faces_[side.face].size() == 3 ? 2 : 1) * area_[side.face] / length_of(side);
}

}  // namespace slim
