#include "slim/smooth/turned_faces.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"

#include <algorithm>
#include <cmath>

namespace slim {
namespace {

constexpr std::size_t kGrain = 8192;
constexpr double kAcross = 0.3;     // cosine: at 72 degrees to the surface a face is across it
constexpr std::uint8_t kStays = 4;  // steps back from which on a vertex stays: 1, 1/2, 1/4, 1/8, 0

/// Cosine of two vectors; NaN if one is zero, which no comparison holds for.
double leans(const Vec3d& a, const Vec3d& b) {
    return dot(a, b) / std::sqrt(sq_length(a) * sq_length(b));
}

/// Twice the area along the normal, by a fan about the first corner.
Vec3d area_vector(std::span<const std::uint32_t> corners, std::span<const Vec3d> at) {
    Vec3d sum;
    for (std::size_t k = 1; k + 1 < corners.size(); ++k)
        sum += cross(at[corners[k]] - at[corners[0]], at[corners[k + 1]] - at[corners[0]]);
    return sum;
}

class HoldBack {
public:
    HoldBack(const Mesh& mesh, std::span<const Vec3f> toward, std::span<const Vec3d> from,
             std::vector<Vec3d>& to)
        : mesh_(mesh), toward_(toward), from_(from), to_(to), wanted_(to),
          steps_(from.size(), 0) {}

    bool turns(std::size_t f) const {
        const auto corners = mesh_.face(f);
        const Vec3d before = area_vector(corners, from_), after = area_vector(corners, to_);
        const Vec3d given = to_double(toward_[f]), way = sq_length(given) > 0 ? given : before;
        return leans(before, way) >= kAcross && leans(after, way) < kAcross;
    }

    /// Those of some faces that turn, rising.
    template <class FaceAt>
    std::vector<std::uint32_t> turned(std::size_t n, const FaceAt& face_at) const {
        std::vector<std::uint8_t> is_turned(n);
        parallel_blocks(n, kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) is_turned[i] = turns(face_at(i)) ? 1 : 0;
        });
        std::vector<std::uint32_t> out;
        for (std::size_t i = 0; i < n; ++i)
            if (is_turned[i]) out.push_back(static_cast<std::uint32_t>(face_at(i)));
        return out;
    }

    /// Takes the corners of faces a step back; returns those that moved.
    std::vector<std::uint32_t> step_back(std::span<const std::uint32_t> faces) {
        std::vector<std::uint32_t> corners;
        for (const std::uint32_t f : faces)
            for (const std::uint32_t v : mesh_.face(f))
                if (steps_[v] < kStays && from_[v] != wanted_[v]) corners.push_back(v);
        std::sort(corners.begin(), corners.end());
        corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
        for (const std::uint32_t v : corners) {
            const double share = ++steps_[v] < kStays ? 1.0 / (1 << steps_[v]) : 0;
            to_[v] = from_[v] + (wanted_[v] - from_[v]) * share;
        }
        return corners;
    }

    std::uint64_t n_held_back() const {
        return static_cast<std::uint64_t>(
            std::count_if(steps_.begin(), steps_.end(), [](std::uint8_t s) { return s > 0; }));
    }
    std::vector<std::uint32_t> kept() const {
        std::vector<std::uint32_t> out;
        for (std::size_t v = 0; v < steps_.size(); ++v)
            if (steps_[v] == kStays) out.push_back(static_cast<std::uint32_t>(v));
        return out;
    }

private:
    const Mesh& mesh_;
    std::span<const Vec3f> toward_;
    std::span<const Vec3d> from_;
    std::vector<Vec3d>& to_;
    const std::vector<Vec3d> wanted_;
    std::vector<std::uint8_t> steps_;  // back, of each vertex
};

}  // namespace

TurnedFaces hold_back_turned(const Mesh& mesh, const VertexFaces& around,
                             std::span<const Vec3f> toward, std::span<const Vec3d> from,
                             std::vector<Vec3d>& to) {
    SLIM_CHECK(toward.size(), ==, mesh.n_faces());
    SLIM_CHECK(from.size(), ==, to.size());
    HoldBack hold(mesh, toward, from, to);
    std::vector<std::uint32_t> turned =
        hold.turned(mesh.n_faces(), [](std::size_t i) { return i; });
    TurnedFaces out;
    out.turned = turned.size();
    // Ends: a face that turns has a corner that is not back yet, which each round takes one of its
    // four steps back.
    while (!turned.empty()) {
        const std::vector<std::uint32_t> moved = hold.step_back(turned);
        std::vector<std::uint32_t> near;
        for (const std::uint32_t v : moved)
            near.insert(near.end(), around.of(v).begin(), around.of(v).end());
        std::sort(near.begin(), near.end());
        near.erase(std::unique(near.begin(), near.end()), near.end());
        turned = hold.turned(near.size(), [&](std::size_t i) { return near[i]; });
    }
    out.n_held_back = hold.n_held_back();
    out.kept = hold.kept();
    return out;
}

}  // namespace slim
