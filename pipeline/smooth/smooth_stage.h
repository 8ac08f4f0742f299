#pragma once

#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

#include <string>

namespace slim {

/// Points or a mesh moved onto a model.
struct SmoothConfig {
    std::string model, cloud, output, mode = "auto", memory = "1GiB";
    int iterations = 1;
    double amount = 1, most = 0;

    template <class Visitor>
    void visit(Visitor&& field) {
        field.input("model", model, "model.slim");
        field.input("cloud", cloud, "cloud or mesh to smooth (PLY, text; also gzip)");
        field.output("output", output,
                     "what to write, in the format and precision of the input; unpacked, also of a "
                     "gzip file");
        field.choice(
            "mode", mode,
            "points: each along its normal; mesh: vertices by the planes of their faces; auto: "
            "mesh for a PLY with faces",
            {"auto", "points", "mesh"});
        field("memory", memory,
              "memory for a cloud, at least 64MiB: with less than it wants a share of the points "
              "is fitted to, or fewer leaves; meshes are held whole");
        field("iterations", iterations,
              "how often, each from where the last one ended; more than once makes a mesh's edges "
              "worse",
              1, 100);
        field("amount", amount, "share of the way to the surface; 0 only renews the normals", 0, 1);
        field("most", most, "no point moves farther than this, model units; 0: no limit", 0, 1e300);
    }
};

/// Writes the points projected onto the model's surface by eqs (6) and (7) (Ohtake 2005, sec. 4;
/// NUMERICS 5.5), with all attributes and in their order, as CloudRewriter does: new normals, and
/// how far each went as scalar_displacement (model units, positive along its new normal,
/// 0 if it stayed).
///
/// Points go on the surface fitted anew to them (RefittedSurface), a mesh's faces on the model's
/// own. Points without support, or whose line meets no surface in reach, are kept as they are.
/// Keys: mode points moved unsupported opposed astray not_finite rms_displacement (of those that
/// moved) max_displacement; for a mesh faces faces_unsupported faces_turned (that would have turned
/// over) vertices_held_back (so that they do not: TurnedFaces) vertices_kept (those of them that
/// stay) held (vertices of the boundary, which stay) at_edges (share of the mesh at feature edges
/// that the model rounds off, feature_edges; with an advice where it has some; none of a model with
/// sharp leaves) instead of opposed, astray, points_by_model (the fits were out of reach)
/// points_held_back (went a share of the way: trusted_share) refit_share, leaves_kept_for_memory,
/// leaves_refitted, leaves_kept (as the model has them: wide_radii) and leaves_stray (left out:
/// RefittedSurface), noise (of the points about the median leaf, over L as in `slim build` and
/// `slim scan`; null: unknown), leaves_noise_unknown (local_noise).
/// throws  NumericalError: no point was moved and some lie in no surfel's support, as in another
///         frame or unit (nothing is written then); DataError: no finite point, or mesh mode
///         without faces; ConfigError: the output is the input or has another format's name; as
///         open_cloud, CloudRewriter and ModelFile
/// cost    points: read twice; within `memory`, which says how many points, leaves and fits there
///         may be (RefitBudget; the index of the leaves, 400 bytes each, is beside it). Fewer than
///         wanted are warned of (leaves_kept_for_memory; refit_share: of the points). A mesh: about
///         300 bytes a vertex, in text twice that
nlohmann::json run_smooth(const SmoothConfig& config, StageContext& context);

}  // namespace slim
