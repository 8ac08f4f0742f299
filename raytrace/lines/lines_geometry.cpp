#include "raytrace/lines/lines_geometry.h"

#include <cstdint>
#include <cstdio>
#include <cstring>

namespace slim {
namespace {

std::string text_of(const char* format, double a, double b, double c) {
    char text[160];
    std::snprintf(text, sizeof text, format, a, b, c);
    return text;
}

/// Little endian, as the machines that this is built for.
template <class T>
void put(std::string& out, T value) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    out.append(bytes, sizeof(T));
}

std::string ply_header(std::size_t n_points, std::size_t n_edges, const Vec3d& origin) {
    std::string out = "ply\nformat binary_little_endian 1.0\n";
    out += text_of("comment slim origin %.17g %.17g %.17g\n", origin.x, origin.y, origin.z);
    for (const LineKind kind : kAllLineKinds)
        out += "comment type " + std::to_string(static_cast<int>(kind)) + " " +
               std::string(line_name(kind)) + "\n";
    out += "element vertex " + std::to_string(n_points) +
           "\nproperty float x\nproperty float y\nproperty float z\n"
           "property float scalar_strength\nproperty float quality\nproperty uchar type\n";
    return out + "element edge " + std::to_string(n_edges) +
           "\nproperty int vertex1\nproperty int vertex2\nend_header\n";
}

}  // namespace

std::string lines_ply(std::span<const FeatureLine> lines, const Vec3d& origin) {
    std::size_t n_points = 0, n_edges = 0;
    for (const FeatureLine& line : lines)
        n_points += line.points.size(), n_edges += line.n_segments();
    std::string out = ply_header(n_points, n_edges, origin);
    for (const FeatureLine& line : lines)
        for (const LinePoint& p : line.points) {
            for (std::size_t axis = 0; axis < 3; ++axis) put(out, p.point[axis]);
            put(out, line.strength);  // as CloudCompare reads it, and as MeshLab does
            put(out, line.strength);
            put(out, static_cast<std::uint8_t>(line.kind));
        }
    std::int32_t first = 0;
    for (const FeatureLine& line : lines) {
        const auto n = static_cast<std::int32_t>(line.points.size());
        for (std::int32_t i = 0; i < static_cast<std::int32_t>(line.n_segments()); ++i)
            put(out, first + i), put(out, first + (i + 1) % n);
        first += n;
    }
    return out;
}

std::string lines_obj(std::span<const FeatureLine> lines, const Vec3d& origin) {
    std::string out = text_of("# slim origin %.17g %.17g %.17g\n", origin.x, origin.y, origin.z);
    std::size_t first = 1;
    for (const LineKind kind : kAllLineKinds) {
        bool named = false;
        for (const FeatureLine& line : lines) {
            if (line.kind != kind) continue;
            if (!named) out += "o " + std::string(line_name(kind)) + "\n";
            named = true;
            for (const LinePoint& p : line.points)
                out += text_of("v %.9g %.9g %.9g\n", static_cast<double>(p.point.x),
                               static_cast<double>(p.point.y), static_cast<double>(p.point.z));
            out += text_of("# strength %.6g\n", static_cast<double>(line.strength), 0, 0) + "l";
            for (std::size_t i = 0; i < line.points.size(); ++i)
                out += " " + std::to_string(first + i);
            out += line.closed ? " " + std::to_string(first) + "\n" : "\n";
            first += line.points.size();
        }
    }
    return out;
}

}  // namespace slim
