#pragma once

#include "slim/base/vec.h"

#include <memory>
#include <span>
#include <string>

namespace slim {

/// What a point becomes in a rewritten cloud.
struct RewrittenPoint {
    Vec3d position;          ///< world frame
    Vec3f normal;            ///< unit; zero: none
    float displacement = 0;  ///< model units
    bool moved = false;      ///< else its coordinates and normal stay as they stand in the file
};

/// A cloud written anew with other positions and normals: the same format, byte order, types of
/// coordinates, order and attributes, faces and all else byte for byte (text: lines end with LF).
///
/// PLY   gets normals (float nx ny nz) if it has none, and `float scalar_displacement`, or new
///       values where it has them. Coordinates and normals of integer types become double and
///       float. `comment slim noise_variance V` says the noise, or what the file said if that is
///       more.
/// text  keeps its columns: nothing is added. Comments, counts and lines of names are kept.
/// A gzip file is written unpacked.
class CloudRewriter {
public:
    virtual ~CloudRewriter() = default;
    /// The next points, in file order. The file must hold as many (a SLIM_CHECK):
    /// it was read before.
    virtual void write(std::span<const RewrittenPoint> points) = 0;
    /// Writes what follows the points and makes the file visible;
    /// every point must have been written.
    virtual void commit() = 0;
};

/// text_step  what coordinates in text are rounded to at the most, world units; a number with more
///            decimals in the file keeps as many
/// noise_variance  of the points as they were, length^2, for CloudInfo; 0: nothing is said of it
/// throws     ConfigError if the name of `out` asks for another format than that of `in`; else as
///            open_cloud and AtomicFile
/// cost       constant memory
std::unique_ptr<CloudRewriter> rewrite_cloud(const std::string& in, const std::string& out,
                                             double text_step, double noise_variance = 0);

}  // namespace slim
