#pragma once

#include "slim/base/bbox.h"
#include "slim/base/vec.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace slim {

/// One cloud of a job, as it was found.
struct PlanInput {
    std::string path;               ///< as it was given
    std::string format;
    std::uint64_t n_points = 0;     ///< in the file, those that were dropped included
    std::uint64_t n_dropped = 0;    ///< without finite coordinates
    std::uint64_t n_bad_normals = 0;///< zero, or not finite and set to it: "none measured"
    bool has_normals = false;
    bool normals_from_faces = false;
    bool faces_turned = false;
    std::uint64_t n_face_points = 0;  ///< of n_points: on large faces of a mesh
    double face_points_from_size = 0; ///< as CloudInfo has it, not written
    std::uint64_t n_undeclared = 0;   ///< as CloudInfo has it, not written
    bool has_scan = false;
    double noise_variance = 0;      ///< that smoothing took off its points; 0: none
    std::uint64_t first_id = 0;     ///< id of its first point
    std::uint32_t first_scan = 0;   ///< added to its own scan numbers
};

struct PlanSlice {
    std::uint64_t n_points = 0;
    Bbox bounds;  ///< of its points, local frame
    Bbox region;  ///< what it owns, local frame: half open, infinite outwards
};

/// What the slice stage decided for a whole job: plan.json in the work folder. Lengths in model
/// units; "local" is world minus origin.
struct SlicePlan {
    std::vector<PlanInput> inputs;
    Vec3d origin;
    Bbox bounds;                ///< local frame, of all finite points
    double diagonal = 0;        ///< L
    std::uint64_t n_points = 0; ///< finite
    std::uint64_t n_dropped = 0;
    double spacing = 0;         ///< square root of the area of one point
    std::vector<PlanSlice> slices;
    bool slices_given = false;  ///< their number was asked for: the memory did not decide
    /// points of the fullest slice with each of possible_halos()
    std::vector<std::uint64_t> most_within;
    std::vector<std::uint64_t> all_within;   ///< and of all slices, each with its halo, added up
    bool has_normals = false;   ///< slices carry them; zero where an input had none
    bool has_scans = false;
    bool is_float32 = false;    ///< some input stores its coordinates as floats
    double coordinate_quantum = 0;  ///< largest step between stored coordinates; 0: not known
};

/// Whether most points of every input are made of a mesh's faces, without noise: what is not flat
/// are edges.
bool is_made_of_faces(const SlicePlan& plan);

/// The mean over all points of the noise that the inputs say was taken off them, length^2.
double smoothed_variance(const SlicePlan& plan);

/// WORK/plan.json and WORK/slice_0007/points.slice.
std::filesystem::path plan_path(const std::filesystem::path& work);
std::filesystem::path slice_folder(const std::filesystem::path& work, std::size_t slice);
std::filesystem::path slice_points_path(const std::filesystem::path& work, std::size_t slice);

/// The slices that have points near to a slice's region, by number, itself included.
std::vector<std::size_t> slices_near(const SlicePlan& plan, std::size_t slice, double distance);

/// Width of the rims of other slices that a slice's normals are seen with: k neighbours of any use
/// lie within it (10 spacings where the area is L^2).
double rim_width(const SlicePlan& plan);

/// Writes WORK/plan.json atomically. Throws as AtomicFile.
void write_plan(const std::filesystem::path& work, const SlicePlan& plan);
/// throws IoError if there is none; FormatError if it is not what write_plan writes
SlicePlan read_plan(const std::filesystem::path& work);

}  // namespace slim
