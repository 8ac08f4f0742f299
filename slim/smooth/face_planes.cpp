#include "slim/smooth/face_planes.h"

#include "slim/base/parallel.h"
#include "slim/smooth/point_projector.h"

#include <Eigen/Eigenvalues>

#include <cmath>

namespace slim {
namespace {

constexpr std::size_t kGrain = 2048;
constexpr double kPull = 0.03;     // towards the vertex, over the area
constexpr double kTruncate = 0.2;  // eigenvalues below this share of the largest

/// Area, normal and centroid by a fan about the first corner.
FacePlane plane_of(const Mesh& mesh, std::size_t f) {
    const auto corners = mesh.face(f);
    if (corners.size() < 3) return {};
    const Vec3d first = mesh.position[corners[0]];
    Vec3d sum, weighted;
    for (std::size_t k = 1; k + 1 < corners.size(); ++k)
        sum += cross(mesh.position[corners[k]] - first, mesh.position[corners[k + 1]] - first);
    const Vec3d normal = normalized(sum);
    for (std::size_t k = 1; k + 1 < corners.size(); ++k) {
        const Vec3d a = mesh.position[corners[k]] - first,
                    b = mesh.position[corners[k + 1]] - first;
        weighted += (a + b) * (dot(cross(a, b), normal) / 3);
    }
    const double twice_area = length(sum);
    if (!(twice_area > 0) || !std::isfinite(twice_area)) return {};
    return {first + weighted / twice_area, normal, twice_area / 2, false};
}

Eigen::Vector3d to_eigen(const Vec3d& a) { return {a.x, a.y, a.z}; }

}  // namespace

std::vector<FacePlane> project_faces(const Mesh& mesh, const BallIndex& index) {
    std::vector<FacePlane> planes(mesh.n_faces());
    parallel_blocks(planes.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        PointProjector projector(index);
        for (std::size_t f = begin; f < end; ++f) {
            FacePlane& plane = planes[f] = plane_of(mesh, f);
            if (!(plane.area > 0)) continue;
            const ProjectedPoint put = projector.project(plane.point, plane.normal);
            if (!put.hit || !(sq_length(put.hit->normal) > 0)) continue;
            plane = {put.hit->point, put.hit->normal, plane.area, true};
        }
    });
    return planes;
}

bool nearest_to_planes(std::span<const FacePlane> planes, std::span<const std::uint32_t> faces,
                       Vec3d& x) {
    double area = 0;
    for (const std::uint32_t f : faces) area += planes[f].area;
    if (!(area > 0)) return false;
    Eigen::Matrix3d m = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const std::uint32_t f : faces) {
        const Eigen::Vector3d n = to_eigen(planes[f].normal);
        const double weight = planes[f].area / area;
        m += weight * n * n.transpose();
        right += weight * dot(planes[f].normal, planes[f].point - x) * n;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solved(m);
    Vec3d moved = x;
    const double largest = solved.eigenvalues()[2];
    for (int i = 0; i < 3; ++i) {
        const double eigenvalue = solved.eigenvalues()[i];
        if (eigenvalue < kTruncate * largest) continue;
        const Eigen::Vector3d axis = solved.eigenvectors().col(i);
        const Eigen::Vector3d step = axis * (axis.dot(right) / (eigenvalue + kPull));
        moved += Vec3d{step.x(), step.y(), step.z()};
    }
    x = moved;
    return true;
}

}  // namespace slim
