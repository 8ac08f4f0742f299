#include "slim/smooth/smoothing.h"

#include "slim/base/check.h"
#include "slim/base/parallel.h"
#include "slim/model/weight_kernel.h"
#include "slim/neighbors/key_sort.h"
#include "slim/neighbors/morton.h"
#include "slim/smooth/face_planes.h"
#include "slim/smooth/point_projector.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace slim {
namespace {

constexpr std::size_t kGrain = 2048;

/// Where a point that was at `from` ends, and how far that is, positive along its new normal.
void end_at(const Vec3d& from, Vec3d to, double most, SmoothedPoint& out) {
    const double distance = length(to - from);
    const bool too_far = most > 0 && distance > most;
    if (too_far) to = from + (to - from) * (most / distance);
    out.position = to;
    out.displacement = std::copysign(too_far ? most : distance, dot(to - from, out.normal));
}

/// Puts points on the fits made anew; those out of their reach by way of the nearest fit's foot, or of the model.
/// Where that ends farther from the model's own projection than fits may be from the model, the latter counts.
class SurfaceProjector {
public:
    explicit SurfaceProjector(const SmoothSurface& surface)
        : model_(surface.model, kTrustedCosine), surface_(surface.refitted), index_(surface.model), trust_(surface.trust) {
        if (surface_) fits_.emplace(surface_->fits(), kTrustedCosine);
    }
    ProjectedPoint project(const Vec3d& p, const Vec3d& normal) {
        asked_at_ = p, by_model_ = !surface_;
        if (!surface_) return model_.project(p, normal);
        const ProjectedPoint put = on_fits(p, normal);
        if (!put.hit || by_model_ || length(put.hit->point - p) <= surface_->least_off(fits_->supporters())) return put;
        ProjectedPoint own = model_.project(p, normal);
        if (!own.hit) return put;
        const double off = length(put.hit->point - own.hit->point);
        if (off <= surface_->most_off(model_.supporters())) return put;
        asked_at_ = p, by_model_ = true;
        return own;
    }
    /// Whether the last point was put on the model's own surface instead of the fits.
    bool by_model() const { return surface_ && by_model_; }
    /// How much of the way that project() found, of a length, the surface is to be trusted with: by the surfels that were
    /// asked, where they were.
    double share(double distance) const {
        if (trust_.empty()) return 1;
        PointTrust trust(distance);
        for (const Surfel* s : (by_model_ ? model_ : *fits_).supporters()) {
            const std::size_t leaf = by_model_ ? index_.number_of(s) : surface_->leaf_of(s);
            trust.add(trust_[leaf],
                      weight_kernel(sq_length(asked_at_ - s->center) / (s->support_radius * s->support_radius)));
        }
        return trust.share();
    }

private:
    ProjectedPoint on_fits(const Vec3d& p, const Vec3d& normal) {
        ProjectedPoint put = fits_->project(p, normal);
        if (put.hit) return put;
        if (const auto foot = surface_->foot(p, is_finite(normal) ? normal : Vec3d{})) {
            asked_at_ = *foot;
            put = fits_->project(*foot, normal);
            if (put.hit) return put;
        }
        put = model_.project(p, normal);
        asked_at_ = p, by_model_ = true;
        if (!put.hit) return put;
        const auto again = fits_->project(put.hit->point, put.hit->normal);
        if (!again.hit) return put;
        asked_at_ = put.hit->point, by_model_ = false;
        put.hit = again.hit;
        return put;
    }

    PointProjector model_;
    const RefittedSurface* surface_;
    const BallIndex& index_;
    std::span<const LeafTrust> trust_;
    std::optional<PointProjector> fits_;
    bool by_model_ = false;
    Vec3d asked_at_;  // where the model, or the fits, were asked last
};

/// Turns a point's normal to the surface's by its share of the way, all of it where it has none or one that faces away.
void turn(const Vec3d& to, double share, Vec3d& normal) {
    const bool own = share < 1 && is_finite(normal) && dot(normal, to) > 0;
    normal = own ? normalized(normalized(normal) * (1 - share) + to * share) : to;
}

SmoothedPoint smooth_point(SurfaceProjector& projector, const SmoothSettings& settings, const Vec3d& from,
                           const Vec3d& own_normal) {
    SmoothedPoint out{from, own_normal};
    if (!is_finite(from)) return out;
    Vec3d p = from, normal = own_normal;
    double share = 1;
    for (int i = 0; i < settings.iterations; ++i) {
        const ProjectedPoint put = projector.project(p, normal);
        if (!put.hit || !(sq_length(put.hit->normal) > 0)) break;
        if (i == 0) {
            share = projector.share(length(put.hit->point - p));
            out.opposed = put.opposed, out.astray = put.astray;
            out.by_model = projector.by_model(), out.held_back = share < 1;
        }
        p += (put.hit->point - p) * settings.amount;
        normal = put.hit->normal;
        out.moved = true;
    }
    if (!out.moved) return out;
    turn(normal, share, out.normal);
    end_at(from, from + (p - from) * share, settings.most, out);
    return out;
}

/// Points along a Morton curve: one after the other asks the same fits, which then lie in the cache (10 million points
/// of a bumpy sphere in random order take a tenth less time).
KeyedIndices near_after_near(std::span<const Vec3d> positions) {
    Bbox box;
    for (const Vec3d& p : positions)
        if (is_finite(p)) box.extend(p);
    const MortonCurve curve(box);
    KeyedIndices order(positions.size());
    for (std::size_t i = 0; i < positions.size(); ++i)
        order[i] = {is_finite(positions[i]) ? curve.key(positions[i]) : 0, static_cast<std::uint32_t>(i)};
    sort_by_key(order);
    return order;
}

/// The mean normal by area of the planes about a vertex, and whether the model supports one of them.
bool normal_of_planes(std::span<const FacePlane> planes, std::span<const std::uint32_t> faces,
                      Vec3d& normal) {
    Vec3d sum;
    bool supported = false;
    for (const std::uint32_t f : faces) {
        sum += planes[f].normal * planes[f].area;
        supported |= planes[f].supported;
    }
    if (sq_length(sum) > 0) normal = normalized(sum);
    return supported;
}

}  // namespace

void smooth_points(const SmoothSurface& surface, const SmoothSettings& settings,
                   std::span<const Vec3d> positions, std::span<const Vec3f> normals,
                   std::span<SmoothedPoint> out) {
    SLIM_CHECK(positions.size(), ==, out.size());
    if (!normals.empty()) SLIM_CHECK(normals.size(), ==, positions.size());
    const KeyedIndices order = near_after_near(positions);
    parallel_blocks(positions.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        SurfaceProjector projector(surface);
        for (std::size_t k = begin; k < end; ++k) {
            const std::size_t i = order[k].index;
            out[i] = smooth_point(projector, settings, positions[i],
                                  normals.empty() ? Vec3d{} : to_double(normals[i]));
        }
    });
}

SmoothedMesh smooth_mesh(const BallIndex& index, const SmoothSettings& settings, Mesh& mesh,
                         const std::function<void(int iteration)>& each_step) {
    const std::vector<Vec3d> from = mesh.position;
    const VertexFaces around(mesh);
    const std::vector<std::uint8_t> held = boundary_vertices(mesh);
    SmoothedMesh out;
    out.vertices.resize(from.size());
    for (int i = 0; i < settings.iterations; ++i) {
        each_step(i);
        const std::vector<FacePlane> planes = project_faces(mesh, index);
        if (i == 0)
            out.faces_unsupported = static_cast<std::uint64_t>(std::count_if(
                planes.begin(), planes.end(), [](const FacePlane& p) { return !p.supported; }));
        parallel_blocks(from.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t v = begin; v < end; ++v) {
                SmoothedPoint& vertex = out.vertices[v];
                Vec3d x = mesh.position[v];
                const bool supported = normal_of_planes(planes, around.of(v), vertex.normal);
                if (!supported || held[v] || !nearest_to_planes(planes, around.of(v), x)) continue;
                mesh.position[v] += (x - mesh.position[v]) * settings.amount;
                vertex.moved = true;
            }
        });
    }
    for (std::size_t v = 0; v < from.size(); ++v) {
        out.vertices[v].position = from[v];
        out.vertices[v].held = held[v] != 0;
        if (out.vertices[v].moved) end_at(from[v], mesh.position[v], settings.most, out.vertices[v]);
    }
    return out;
}

}  // namespace slim
