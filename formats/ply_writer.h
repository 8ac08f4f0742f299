#pragma once

#include "formats/atomic_file.h"
#include "slim/base/vec.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace slim {

/// What a PLY of points carries (CONVENTIONS 1.5).
struct PlyLayout {
    bool double_positions = false;  ///< float reads everywhere; double only in some programs
    bool normals = false;           ///< float nx ny nz
    bool colours = false;           ///< uchar red green blue
    bool scan = false;              ///< ushort scan
    /// float; names as they shall stand ("scalar_k1", "quality", "radius")
    std::vector<std::string> scalars;
    /// `comment slim origin X Y Z`; positions are given local to it
    std::optional<Vec3d> origin;
    std::vector<std::string> comments;
    std::optional<std::uint64_t> n_faces;  ///< element face, `list uchar int
                                           ///< vertex_indices`; all follow the points
    bool large_faces = false;       ///< some have more than 255 corners: their counts are int
    bool ascii = false;             ///< else binary little endian
};

/// Columns of some consecutive points; those that the layout does not name are ignored, those that
/// it names must have as many entries as there are positions (a SLIM_CHECK).
struct PlyPoints {
    std::span<const Vec3d> position;  ///< local to the layout's origin
    std::span<const Vec3f> normal;
    std::span<const std::uint8_t> colour;   ///< 3 a point
    std::span<const std::uint16_t> scan;
    std::span<const float> scalars;         ///< row by row, layout.scalars.size() a point
};

/// Writes points as they come; the count is put into the header at the end. Throws as AtomicFile.
class PlyWriter {
public:
    PlyWriter(const std::string& path, PlyLayout layout);
    void write(const PlyPoints& points);
    /// The next face, after all points; corners by the points' numbers.
    void write_face(std::span<const std::uint32_t> corners);
    /// Completes the header (as many faces as the layout says, a SLIM_CHECK) and makes the file
    /// visible; without it nothing is left behind.
    void commit();
    std::uint64_t n_points() const { return n_points_; }

private:
    std::string header() const;
    void put_record(const PlyPoints& points, std::size_t i);
    template <class T>
    void put(T value);

    AtomicFile file_;
    PlyLayout layout_;
    std::uint64_t n_points_ = 0, n_faces_ = 0;
    std::vector<char> row_;
};

}  // namespace slim
