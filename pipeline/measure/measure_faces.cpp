#include "pipeline/measure/measure_faces.h"

#include "formats/face_triangles.h"
#include "formats/ply_faces.h"
#include "formats/ply_reader.h"
#include "pipeline/measure/mesh_input.h"
#include "slim/base/area_vector.h"
#include "slim/base/hash.h"
#include "slim/base/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

namespace slim {
namespace {

using nlohmann::json;

constexpr std::size_t kSamples = 200'000;
constexpr std::size_t kGrain = 2048;
constexpr std::uint64_t kPlaces = 0x73616d70;  // purpose of the hash

/// Where the vertices of a mesh lie, and which way they say that the surface faces.
struct Vertices {
    std::vector<Vec3d> position;
    std::vector<Vec3f> normal;  ///< empty if the file has none
};

Vertices read_vertices(PlyReader& file, const std::string& path, const Vec3d& origin) {
    constexpr std::size_t kChunk = 1 << 16;
    Vertices out;
    const std::uint64_t n = file.info().n_points.value_or(0);
    if (n >= std::numeric_limits<std::uint32_t>::max())
        throw too_many_vertices(path, n);
    for (PointChunk chunk; file.read(chunk, kChunk);) {
        if (out.position.empty()) {  // as many as declared: read as they are there
            out.position.reserve(n);
            if (!chunk.normal.empty()) out.normal.reserve(n);
        }
        for (const Vec3d& p : chunk.position) out.position.push_back(p - origin);
        out.normal.insert(out.normal.end(), chunk.normal.begin(), chunk.normal.end());
    }
    return out;
}

/// The triangles of a mesh's faces, and which of them holds a share of the area. Those that are
/// wound against their vertices' normals are turned.
class FaceArea {
public:
    FaceArea(const std::string& path, const Vec3d& origin) {
        Vertices vertices;
        {
            PlyReader file(path);
            vertices = read_vertices(file, path, origin);
            triangles_.reserve(file.info().n_faces), area_until_.reserve(file.info().n_faces);
        }
        std::vector<Vec3d> corners;
        read_ply_faces(path, vertices.position.size(), [&](std::span<const std::size_t> face) {
            corners.clear();
            for (const std::size_t v : face) corners.push_back(vertices.position[v]);
            add(face, corners, vertices.normal);
        });
        position_ = std::move(vertices.position);
    }
    double area() const { return area_until_.empty() ? 0 : area_until_.back(); }

    struct Sample {
        Vec3d place, normal;  ///< normal: of any length
    };
    /// One of n, each for the same area; the same for the same i.
    Sample sample(std::size_t i, std::size_t n) const {
        const auto random = [&](std::uint64_t k) {
            return unit_interval(keyed_hash(i, k, kPlaces));
        };
        const double share = (static_cast<double>(i) + random(0)) / static_cast<double>(n);
        const auto found =
            std::upper_bound(area_until_.begin(), area_until_.end() - 1, share * area());
        const auto& t = triangles_[static_cast<std::size_t>(found - area_until_.begin())];
        const Vec3d &a = position_[t[0]], b = position_[t[1]] - a, c = position_[t[2]] - a;
        double u = random(1), v = random(2);
        if (u + v > 1) u = 1 - u, v = 1 - v;
        return {a + u * b + v * c, cross(b, c)};
    }

private:
    void add(std::span<const std::size_t> face, const std::vector<Vec3d>& corners,
             const std::vector<Vec3f>& normals) {
        const Vec3d area = area_vector(corners);
        if (face.size() < 3 || !std::isfinite(length(area)) || !(length(area) > 0)) return;
        Vec3d own;
        if (!normals.empty())
            for (const std::size_t v : face) own += to_double(normals[v]);
        const std::array<std::size_t, 3> order =
            dot(own, area) < 0 ? std::array<std::size_t, 3>{0, 2, 1}
                               : std::array<std::size_t, 3>{0, 1, 2};
        for (const Corners& t : triangles_of(corners, area)) {
            sum_ += fan_area(Triangle{corners[t[0]], corners[t[1]], corners[t[2]]});
            const auto vertex = [&](std::size_t k) {
                return static_cast<std::uint32_t>(face[t[order[k]]]);
            };
            triangles_.push_back({vertex(0), vertex(1), vertex(2)});
            area_until_.push_back(sum_);
        }
    }

    double sum_ = 0;
    std::vector<Vec3d> position_;
    std::vector<std::array<std::uint32_t, 3>> triangles_;
    std::vector<double> area_until_;
};

struct Found {
    double distance = std::numeric_limits<double>::quiet_NaN();  // missed
    double angle = 0;  ///< between the normals, without sign; degrees
    bool opposed = false;
};

std::vector<Found> put_on(const MeasuredSurface& surface, const FaceArea& faces, bool inwards) {
    std::vector<Found> found(kSamples);
    parallel_blocks(kSamples, kGrain, [&](std::size_t begin, std::size_t end) {
        const PutPoint put = surface.new_projector();
        for (std::size_t i = begin; i < end; ++i) {
            const FaceArea::Sample s = faces.sample(i, kSamples);
            const Vec3d normal = normalized(inwards ? -s.normal : s.normal);
            const ProjectedPoint at = put(s.place, normal, false);
            if (!at.hit) continue;
            const double cosine = std::min(1.0, std::abs(dot(normal, at.hit->normal)));
            found[i] = {std::abs(at.hit->t), std::acos(cosine) * 180 / std::numbers::pi,
                        at.opposed};
        }
    });
    return found;
}

}  // namespace

json measure_faces(const MeasuredSurface& surface, const std::string& path, bool inwards,
                   double tolerance, StageContext& context) {
    const FaceArea faces(path, surface.origin);
    if (!(faces.area() > 0) || !std::isfinite(faces.area())) return {};
    context.check_stop();
    const std::vector<Found> found = put_on(surface, faces, inwards);
    std::size_t missed = 0, opposed = 0, within = 0, farthest = kSamples;
    double sum = 0, sq_angle = 0;
    LogHistogram distances;
    for (std::size_t i = 0; i < kSamples; ++i) {
        const double d = found[i].distance;
        if (std::isnan(d)) {
            ++missed;
            continue;
        }
        opposed += found[i].opposed ? 1 : 0;
        within += d <= tolerance * surface.diagonal ? 1 : 0;
        sum += d * d;
        sq_angle += found[i].angle * found[i].angle;
        distances.add(d);
        if (farthest == kSamples || d > found[farthest].distance) farthest = i;
    }
    const auto hits = static_cast<double>(kSamples - missed);
    json out = {{"samples", kSamples},
                {"area", faces.area()},
                {"missed", missed},
                {"opposed", opposed},
                {"l2", rms(sum, hits, surface.diagonal)},
                {"normal_rms_deg", rms(sq_angle, hits)},
                {"max", json()},
                {"max_at", json()},
                {"completeness", static_cast<double>(within) / static_cast<double>(kSamples)}};
    if (farthest < kSamples) {
        const Vec3d at = faces.sample(farthest, kSamples).place + surface.origin;
        out["max"] = found[farthest].distance / surface.diagonal;
        out["max_at"] = {at.x, at.y, at.z};
    }
    put_percentiles(distances, surface.diagonal, out);
    return out;
}

}  // namespace slim
