#pragma once

#include "slim/base/vec.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace slim {

/// How a cloud writes its coordinates; a fit wants to know how coarse they are.
enum class CoordinateType { float32, float64, integer, text };

/// What is known of a cloud before its points are read.
struct CloudInfo {
    std::string path;
    /// "PLY ascii", "PLY binary little endian", "XYZ text", ... (+ " gzip")
    std::string format;
    std::optional<std::uint64_t> n_points;  ///< as declared; nothing if the file does not say
    std::uint64_t n_undeclared = 0;  ///< read so far beyond what the counts of a PTS declare
    bool has_normals = false;               ///< read or made from faces
    bool has_scan = false;
    bool reads_color = false;  ///< opened by open_colored_cloud
    std::uint64_t n_faces = 0;  ///< as declared
    std::uint64_t n_face_points = 0;  ///< the last ones of n_points: on large faces, no vertices
    /// parts of a mesh below that size have fewer face points than they ask for, as these would be
    /// too many; 0: none has
    double face_points_from_size = 0;
    bool has_faces() const { return n_faces > 0; }
    bool normals_from_faces = false;
    /// a closed mesh wound inwards: its normals were turned
    bool faces_turned = false;
    std::vector<std::string> carried;       ///< names of properties that are read
    std::vector<std::string> colors;        ///< names of what open_colored_cloud
                                            ///< reads, if there is any
    std::vector<std::string> skipped;       ///< names of all other properties of
                                            ///< a point: passed over
    CoordinateType coordinates = CoordinateType::float64;
    std::optional<Vec3d> origin;            ///< of the header; already added to what read() gives
    /// of the points before `slim smooth` took it off them, length^2; 0: the file does not say
    double noise_variance = 0;
    std::uint64_t file_size = 0;
};

/// Some consecutive points as flat arrays.
struct PointChunk {
    std::vector<Vec3d> position;      ///< world frame; may hold NaN and infinities as the file does
    std::vector<Vec3f> normal;        ///< as in the file, not normalised; empty if it has none
    std::vector<std::uint16_t> scan;  ///< empty if the file has none
    std::vector<Vec3f> color;         ///< as displayed (sRGB), 0 to 1; empty unless it is read

    std::size_t size() const { return position.size(); }
    void resize(std::size_t n, const CloudInfo& info) {
        position.resize(n);
        normal.resize(info.has_normals ? n : 0);
        scan.resize(info.has_scan ? n : 0);
        color.resize(info.reads_color ? n : 0);
    }
};

/// A cloud read once from front to back. Open it again for a second pass.
class PointSource {
public:
    virtual ~PointSource() = default;
    const CloudInfo& info() const { return info_; }
    /// Replaces `out` by the next points, at most max_points; false (and empty) when there are no
    /// more.
    /// throws FormatError naming the file, the byte or line, what was expected and what was found
    virtual bool read(PointChunk& out, std::size_t max_points) = 0;
    /// Bytes of the file taken in so far, of info().file_size.
    virtual std::uint64_t bytes_read() const = 0;

protected:
    CloudInfo info_;
};

/// Opens a PLY (ascii, either byte order) or a text of coordinates (.xyz .txt .asc .pts .csv),
/// packed with gzip or not; what it is, is seen in its first bytes.
/// throws IoError if it cannot be read; FormatError for any other format, naming those that are
/// read
/// cost   constant memory, except for a PLY with faces and no normals: 72 bytes per vertex, with
///        face_points 4 more a corner of its faces and 92 a point that is added; while these are
///        made some 120 a face if any is large
/// face_points: of a PLY with faces and no normals, points on its large faces follow the vertices
std::unique_ptr<PointSource> open_cloud(const std::string& path, bool face_points = false);

/// The same for a second pass over a PLY's points with their colours (red green blue, or
/// diffuse_red ...: integers over their type's largest value, floats as they are); normals only of
/// the file itself. Null if it has no colour.
std::unique_ptr<PointSource> open_colored_cloud(const std::string& path);

}  // namespace slim
