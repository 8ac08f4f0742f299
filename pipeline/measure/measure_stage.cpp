#include "pipeline/measure/measure_stage.h"

#include "formats/atomic_file.h"
#include "formats/extension.h"
#include "formats/model_file.h"
#include "formats/truth_file.h"
#include "pipeline/input_kind.h"
#include "pipeline/json_text.h"
#include "pipeline/manifest.h"
#include "pipeline/measure/apart.h"
#include "pipeline/measure/measure_back.h"
#include "pipeline/measure/measure_cloud.h"
#include "pipeline/measure/measure_clouds.h"
#include "pipeline/measure/measure_meshes.h"
#include "pipeline/measure/measure_pictures.h"
#include "pipeline/measure/mesh_input.h"
#include "pipeline/shape_name.h"
#include "slim/base/error.h"
#include "slim/shapes/foot_point.h"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

namespace slim {
namespace {

using nlohmann::json;

constexpr const char* kShape = "shape:";

bool is_of_shape(const MeasureConfig& config) { return config.model.starts_with(kShape); }

/// The model as what a cloud is measured against; `index` must outlive it.
MeasuredSurface surface_of(const MeasureConfig& config, const ModelHeader& header,
                           const BallIndex& index) {
    return {header.origin, header.diagonal,
            [&index]() -> PutPoint {
                return [projector = PointProjector(index)](const Vec3d& p, const Vec3d& n,
                                                           bool curvature) mutable {
                    return projector.project(p, n, curvature);
                };
            },
            config.two_way && is_mesh(config.cloud), placed(config.model, header)};
}

/// A point put on an analytic shape: at its foot, the nearest point, if that is known and no
/// farther than kFarOffShape.
ProjectedPoint put_on(const Shape& shape, const Vec3d& p, const Vec3d& own_normal) {
    ProjectedPoint out;
    out.has_normal = is_finite(own_normal) && sq_length(own_normal) > 0;
    const double far = kFarOffShape * shape.bounds.diagonal();
    if (shape.bounds.sq_distance(p) > far * far) return out;
    const auto foot = nearest_point(shape, p);
    if (!foot) return out;
    const SurfacePoint at = surface_point(shape.jet(foot->point));
    out.direction = out.has_normal ? normalized(own_normal) : at.normal;
    Projection hit;
    hit.point = foot->point, hit.t = -foot->signed_distance, hit.normal = at.normal;
    hit.curvature.k1 = at.k1, hit.curvature.k2 = at.k2;
    hit.curvature.mean = (at.k1 + at.k2) / 2, hit.curvature.gauss = at.k1 * at.k2;
    out.opposed = out.has_normal && dot(out.direction, at.normal) < 0;
    out.hit = hit;
    return out;
}

json against_shape(const MeasureConfig& config, const CloudFiles& files, StageContext& context) {
    const Shape& shape = shape_named(config.model.substr(std::string(kShape).size()), "model");
    if (config.two_way)
        throw ConfigError({.key = "two_way",
                           .problem = "a shape is measured against one way only",
                           .expected = "a model"});
    const MeasuredSurface surface{shape_offset(config.offset), shape.bounds.diagonal(),
                                  [&shape]() -> PutPoint {
                                      return [&shape](const Vec3d& p, const Vec3d& n, bool) {
                                          return put_on(shape, p, n);
                                      };
                                  }};
    json out = measure_cloud(surface, files, config.tolerance, context);
    if (const auto missed = out["missed"].get<std::uint64_t>(); missed > 0)
        context.reporter.warn(
            fmt::format("{}: {} of its {} points not measured (\"missed\"): too far from {}, or no "
                        "nearest point of it found",
                        config.cloud, missed, out["points"].get<std::uint64_t>(), config.model));
    return out;
}

/// The result without its record.
json measured(const MeasureConfig& config, const CloudFiles& files, StageContext& context) {
    if (is_of_shape(config)) return against_shape(config, files, context);
    const ModelFile model = ModelFile::open(config.model);
    const SurfelTree tree = model.tree();
    LeafHessians hessians(tree);
    if (!files.truth.empty()) hessians.prepare_all();  // curvature is measured against it alone
    const BallIndex index(tree, &hessians);
    json out =
        measure_cloud(surface_of(config, model.header(), index), files, config.tolerance, context);
    warn_of_lost(config.cloud, config.model, out["missed"], out["points"], context.reporter);
    out["leaves"] = model.header().n_leaves;
    out["bytes"] = model.file_size();
    if (config.two_way)
        out["model_to_cloud"] =
            measure_back(model, index, config.cloud, config.samples, config.tolerance, context);
    return out;
}

void check_order(const MeasureConfig& config) {
    if (is_of_shape(config)) return;
    if (input_kind(config.cloud) == InputKind::model &&
        input_kind(config.model) == InputKind::cloud)
        throw ConfigError(fmt::format(
            "{0} is a cloud and {1} a model: expected the model first: slim measure {1} {0}",
            config.model, config.cloud));
    require_model(config.model);
}

/// The work's result; where a file of it is asked for, from its record if it is up to date.
template <class Work>
json recorded(const MeasureConfig& config, const std::string& truth, StageContext& context,
              Work&& work) {
    if (config.output.empty()) return work();
    Stamp stamp(context, manifest_path(config.output));
    is_of_shape(config) ? stamp.depends(config.model) : stamp.input(config.model);
    stamp.input(config.cloud);
    if (!truth.empty()) stamp.input(truth);
    stamp.outputs({config.output});
    if (!config.per_point.empty()) stamp.outputs({config.per_point});
    if (auto done = stamp.up_to_date()) return *done;
    json result = work();
    if (!is_picture(config.output)) write_file_atomically(config.output, text_of(result, 2) + "\n");
    return stamp.commit(std::move(result));
}

json measure_points(const MeasureConfig& config, StageContext& context) {
    check_measure_options(config);
    check_order(config);
    CloudFiles files{config.cloud, config.truth, config.per_point};
    if (files.truth.empty() && std::filesystem::exists(truth_path(config.cloud)))
        files.truth = truth_path(config.cloud);
    for (const std::string& output : {config.output, config.per_point})
        refuse_to_overwrite(output, {files.truth});
    return recorded(config, files.truth, context, [&] { return measured(config, files, context); });
}

/// What is compared.
enum class Kind { points, pictures, meshes, clouds };

/// What the options are of that are not of every kind.
constexpr const char* kOfModel = "a cloud against a model";
constexpr const char* kOfPoints = "a cloud against a model, or of two clouds or meshes";
constexpr const char* kOfShape = "a cloud against a shape (shape:NAME)";
constexpr const char* kOfClouds = "a cloud against a model, or of two clouds";

/// Options that are of another kind of measure and were given all the same.
void refuse_without_effect(const MeasureConfig& config, Kind kind) {
    const MeasureConfig as_before;
    const bool model = kind == Kind::points, clouds = model || kind == Kind::clouds,
               pictures = kind == Kind::pictures;
    struct Given {
        bool without_effect;
        const char *key, *of;
    };
    const Given given[] = {
        {pictures && !config.per_point.empty(), "per_point", kOfPoints},
        {!model && !config.truth.empty(), "truth", kOfModel},
        {!clouds && config.two_way, "two_way", kOfClouds},
        {!model && config.samples != as_before.samples, "samples", kOfModel},
        {!clouds && config.tolerance != as_before.tolerance, "tolerance", kOfClouds},
        {!is_of_shape(config) && !config.offset.empty(), "offset", kOfShape},
        {!pictures && config.threshold != as_before.threshold, "threshold", "two pictures"}};
    for (const Given& g : given)
        if (g.without_effect)
            throw ConfigError(
                {.key = g.key,
                 .problem = fmt::format("is of {}", g.of),
                 .found = fmt::format("{} and {}{}", config.model, config.cloud,
                                      kind == Kind::meshes
                                          ? ": the first has faces, so that the second counts as "
                                            "the same mesh with its vertices moved"
                                          : "")});
}

/// Names that could not be written, before any work.
void check_outputs(const MeasureConfig& config, Kind kind) {
    for (const std::string& output : {config.output, config.per_point})
        refuse_to_overwrite(output, {config.model, config.cloud});
    if (!config.per_point.empty()) refuse_to_overwrite(config.per_point, {config.output});
    const std::string ending = lower_extension(config.output);
    const bool pictures = kind == Kind::pictures;
    if (!config.output.empty() && ending != ".json" && !(pictures && ending == ".png"))
        throw ConfigError(
            {.file = config.output,
             .problem = fmt::format("the result is written as JSON{}",
                                    pictures                    ? ", the difference as PNG"
                                    : is_picture(config.output) ? ", a picture only of two pictures"
                                                                : ""),
             .expected = fmt::format("a name ending in .json{}", pictures ? " or .png" : "")});
    check_per_point(config);
}

json measure_meshes(const MeasureConfig& config, StageContext& context) {
    return recorded(config, "", context,
                    [&] { return compare_meshes(config.model, config.cloud, config.per_point); });
}

json measure_clouds(const MeasureConfig& config, StageContext& context) {
    const ComparedClouds clouds{config.model, config.cloud, config.per_point, config.tolerance,
                                config.two_way};
    return recorded(config, "", context, [&] { return compare_clouds(clouds, context); });
}

/// A difference picture without any is black: said in words.
json said_if_equal(const MeasureConfig& config, json result, StageContext& context) {
    if (result["max"] == 0.0 && result["not_finite"] == 0)
        context.reporter.info(
            fmt::format("no difference between {} and {}{}{}", config.model, config.cloud,
                        result["identical"] == true ? "" : " in the channels that both have",
                        result.contains("difference") ? ": " + config.output + " is black" : ""));
    return result;
}

json measure_pictures(const MeasureConfig& config, StageContext& context) {
    context.headlines = {{"identical", ""},          {"max", ""},    {"rms", ""},   {"mean", ""},
                         {"above", "of the pixels"}, {"max_at", ""}, {"pixels", ""}};
    const std::string difference = is_picture(config.output) ? config.output : "";
    return said_if_equal(config,
                         recorded(config, "", context,
                                  [&] {
                                      return compare_pictures(config.model, config.cloud,
                                                              difference, config.threshold);
                                  }),
                         context);
}

/// What two files are, in place of model and cloud. A cloud beside itself is a mistake,
/// and told so.
Kind kind_of(const MeasureConfig& config) {
    const bool a = is_picture(config.model), b = is_picture(config.cloud);
    if (a != b)
        throw ConfigError(fmt::format("{}: a picture is compared with a picture; found {}",
                                      a ? config.model : config.cloud,
                                      a ? config.cloud : config.model));
    if (a) return Kind::pictures;
    if (input_kind(config.model) != InputKind::cloud ||
        input_kind(config.cloud) != InputKind::cloud)
        return Kind::points;
    std::error_code none;
    const bool to_points = config.two_way && !is_mesh(config.cloud);  // to which faces say nothing
    if (is_mesh(config.model) && !to_points) return Kind::meshes;
    return std::filesystem::equivalent(config.model, config.cloud, none) ? Kind::points
                                                                         : Kind::clouds;
}

}  // namespace

json run_measure(const MeasureConfig& config, StageContext& context) {
    const Kind kind = kind_of(config);
    refuse_without_effect(config, kind);
    check_outputs(config, kind);
    switch (kind) {
        case Kind::pictures:
            return measure_pictures(config, context);
        case Kind::meshes:
            return measure_meshes(config, context);
        case Kind::clouds:
            return measure_clouds(config, context);
        default:
            return measure_points(config, context);
    }
}

}  // namespace slim
