#include "formats/ply_face_normals.h"

#include "formats/face_points.h"
#include "formats/ply_faces.h"
#include "slim/base/bbox.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace slim {
namespace {

constexpr std::size_t kChunk = std::size_t{1} << 16;

/// Unit length without underflow or overflow on the way.
Vec3f unit_normal(const Vec3d& sum) {
    const double scale = std::max({std::abs(sum.x), std::abs(sum.y), std::abs(sum.z)});
    if (!(scale > 0) || !is_finite(sum)) return {};
    return to_float(normalized(sum / scale));
}

}  // namespace

PlyFaceNormals::PlyFaceNormals(PlyReader& vertices, bool face_points) {
    info_ = vertices.info();
    PointChunk chunk;
    while (vertices.read(chunk, kChunk)) {
        all_.position.insert(all_.position.end(), chunk.position.begin(), chunk.position.end());
        all_.scan.insert(all_.scan.end(), chunk.scan.begin(), chunk.scan.end());
    }
    info_.has_normals = info_.normals_from_faces = true;
    sums_.resize(all_.size());
    find_middle();
    read_ply_faces(info_.path, all_.size(), [&](auto corners) { add_polygon(corners); });
    info_.faces_turned = wound_inwards();
    if (info_.faces_turned)
        for (Vec3d& sum : sums_) sum = -sum;
    all_.normal.resize(all_.size());
    std::transform(sums_.begin(), sums_.end(), all_.normal.begin(), unit_normal);
    sums_ = {};
    if (face_points) add_face_points();
}

void PlyFaceNormals::add_face_points() {
    const std::size_t n_vertices = all_.size();
    FacePoints faces;
    std::vector<Vec3d> places;
    const auto for_each_face = [&](const auto& take) {
        read_ply_faces(info_.path, n_vertices, [&](std::span<const std::size_t> corners) {
            places.clear();
            for (const std::size_t vertex : corners) places.push_back(all_.position[vertex]);
            take(corners);
        });
    };
    for_each_face([&](auto) { faces.measure(places); });
    faces.choose_spacing(2 * reach_, n_vertices);
    std::vector<FacePoints::Point> added;
    if (faces.wants_sizes()) {
        FaceList list;
        list.position = std::span(all_.position).first(n_vertices);
        for_each_face([&](std::span<const std::size_t> corners) {
            for (const std::size_t v : corners)
                list.corner.push_back(static_cast<std::uint32_t>(v));
            list.end.push_back(list.corner.size());
        });
        faces.sample_sized(list, added);
    }
    for_each_face([&](auto corners) { faces.sample(places, corners, added); });
    for (const FacePoints::Point& p : added) {
        all_.position.push_back(p.position);
        all_.normal.push_back(to_float(info_.faces_turned ? -p.normal : p.normal));
        if (info_.has_scan) all_.scan.push_back(all_.scan[p.vertex]);
    }
    info_.n_face_points = added.size();
    info_.face_points_from_size = faces.least_size();
    info_.n_points = all_.size();
}

void PlyFaceNormals::find_middle() {
    Bbox box;
    for (const Vec3d& p : all_.position)
        if (is_finite(p)) box.extend(p);
    if (box.empty()) return;
    middle_ = box.center();
    reach_ = box.diagonal() / 2;
}

/// The middle may move by reach_ without changing the sign: range images, which enclose nothing,
/// stay as they are, and meshes with small holes are told.
bool PlyFaceNormals::wound_inwards() const { return volume_ < -reach_ * length(area_); }

void PlyFaceNormals::add_polygon(std::span<const std::size_t> corners) {
    if (corners.size() < 3) return;
    // The sum over a fan about the first corner is twice the polygon's area vector.
    const Vec3d& first = all_.position[corners[0]];
    Vec3d area;
    for (std::size_t k = 1; k + 1 < corners.size(); ++k)
        area += cross(all_.position[corners[k]] - first, all_.position[corners[k + 1]] - first);
    if (!is_finite(area)) return;
    for (const std::size_t vertex : corners) sums_[vertex] += area;
    area_ += area;
    volume_ += dot(first - middle_, area);
}

bool PlyFaceNormals::read(PointChunk& out, std::size_t max_points) {
    const std::size_t n = std::min(max_points, all_.size() - n_given_);
    out.resize(n, info_);
    const auto from = static_cast<std::ptrdiff_t>(n_given_);
    std::copy_n(all_.position.begin() + from, n, out.position.begin());
    std::copy_n(all_.normal.begin() + from, n, out.normal.begin());
    if (info_.has_scan) std::copy_n(all_.scan.begin() + from, n, out.scan.begin());
    n_given_ += n;
    return n > 0;
}

std::unique_ptr<PointSource> open_ply(const std::string& path, bool face_points) {
    auto reader = std::make_unique<PlyReader>(path);
    const CloudInfo& info = reader->info();
    if (info.has_normals || !info.has_faces() || !reader->has_corner_lists()) return reader;
    return std::make_unique<PlyFaceNormals>(*reader, face_points);
}

}  // namespace slim
