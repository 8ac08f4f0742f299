#include "pipeline/measure_stage.h"

#include "formats/atomic_file.h"
#include "formats/model_file.h"
#include "formats/truth_file.h"
#include "pipeline/input_kind.h"
#include "pipeline/json_text.h"
#include "pipeline/manifest.h"
#include "pipeline/measure_back.h"
#include "pipeline/measure_cloud.h"
#include "pipeline/measure_meshes.h"
#include "pipeline/measure_pictures.h"
#include "pipeline/mesh_input.h"
#include "slim/base/error.h"
#include "slim/shapes/foot_point.h"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

namespace slim {
namespace {

using nlohmann::json;

constexpr const char* kShape = "shape:";

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

/// A point put on an analytic shape: at its foot, the nearest point, if that is known.
ProjectedPoint put_on(const Shape& shape, const Vec3d& p, const Vec3d& own_normal) {
    ProjectedPoint out;
    out.has_normal = is_finite(own_normal) && sq_length(own_normal) > 0;
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
    const Shape& shape = find_shape(config.model.substr(std::string(kShape).size()));
    if (config.two_way)
        throw ConfigError("two_way: a shape is measured against one way only; expected a model");
    const MeasuredSurface surface{{}, shape.bounds.diagonal(), [&shape]() -> PutPoint {
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
    if (config.model.starts_with(kShape)) return against_shape(config, files, context);
    const ModelFile model = ModelFile::open(config.model);
    const SurfelTree tree = model.tree();
    const BallIndex index(tree);
    json out =
        measure_cloud(surface_of(config, model.header(), index), files, config.tolerance, context);
    const auto points = out["points"].get<std::uint64_t>(),
               missed = out["missed"].get<std::uint64_t>();
    if (2 * missed > points)
        context.reporter.warn(fmt::format(
            "{}: {} of its {} points lie in no surfel's support of {}: are they in the same frame?",
            config.cloud, missed, points, config.model));
    out["leaves"] = model.header().n_leaves;
    out["bytes"] = model.file_size();
    if (config.two_way)
        out["model_to_cloud"] =
            measure_back(model, index, config.cloud, config.samples, config.tolerance, context);
    return out;
}

void check_order(const MeasureConfig& config) {
    if (config.model.starts_with(kShape)) return;
    if (input_kind(config.cloud) == InputKind::model &&
        input_kind(config.model) == InputKind::cloud)
        throw ConfigError(fmt::format(
            "{0} is a cloud and {1} a model: expected the model first: slim measure {1} {0}",
            config.model, config.cloud));
    require_model(config.model);
}

json measure_points(const MeasureConfig& config, StageContext& context) {
    if (!config.two_way && config.samples != MeasureConfig{}.samples)
        throw ConfigError(
            "samples are those of the model's surface, which is not measured: expected --two-way "
            "with it");
    check_order(config);
    CloudFiles files{config.cloud, config.truth, config.per_point};
    if (files.truth.empty() && std::filesystem::exists(truth_path(config.cloud)))
        files.truth = truth_path(config.cloud);
    refuse_to_overwrite(config.output, {config.model, config.cloud, files.truth});
    refuse_to_overwrite(config.per_point, {config.model, config.cloud, files.truth, config.output});
    if (config.output.empty()) return measured(config, files, context);
    Stamp stamp(context, manifest_path(config.output));
    config.model.starts_with(kShape) ? stamp.depends(config.model) : stamp.input(config.model);
    stamp.input(config.cloud);
    if (!files.truth.empty()) stamp.input(files.truth);
    stamp.outputs({config.output});
    if (!config.per_point.empty()) stamp.outputs({config.per_point});
    if (auto done = stamp.up_to_date()) return *done;
    json result = measured(config, files, context);
    write_file_atomically(config.output, text_of(result, 2) + "\n");
    return stamp.commit(std::move(result));
}

/// What is compared.
enum class Kind { points, pictures, meshes };

/// Options that are of another kind of measure and were given all the same.
void refuse_without_effect(const MeasureConfig& config, Kind kind) {
    const MeasureConfig as_before;
    const bool points = kind == Kind::points, pictures = kind == Kind::pictures;
    const std::pair<bool, const char*> given[] = {
        {!points && !config.per_point.empty(), "per_point"},
        {!points && !config.truth.empty(), "truth"},
        {!points && config.two_way, "two_way"},
        {!points && config.samples != as_before.samples, "samples"},
        {!points && config.tolerance != as_before.tolerance, "tolerance"},
        {!pictures && config.threshold != as_before.threshold, "threshold"}};
    for (const auto& [is_given, key] : given)
        if (is_given)
            throw ConfigError(fmt::format(
                "{}: is of {}; found {} and {}", key,
                std::string(key) == "threshold" ? "two pictures" : "a cloud against a model",
                config.model, config.cloud));
}

json measure_meshes(const MeasureConfig& config, StageContext& context) {
    refuse_to_overwrite(config.output, {config.model, config.cloud});
    if (config.output.empty()) return compare_meshes(config.model, config.cloud);
    Stamp stamp(context, manifest_path(config.output));
    stamp.input(config.model);
    stamp.input(config.cloud);
    stamp.outputs({config.output});
    if (auto done = stamp.up_to_date()) return *done;
    json result = compare_meshes(config.model, config.cloud);
    write_file_atomically(config.output, text_of(result, 2) + "\n");
    return stamp.commit(std::move(result));
}

/// A mesh in place of the model, a cloud beside it.
bool are_meshes(const MeasureConfig& config) {
    return input_kind(config.model) == InputKind::cloud &&
           input_kind(config.cloud) == InputKind::cloud && is_mesh(config.model);
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
    refuse_to_overwrite(config.output, {config.model, config.cloud});
    if (config.output.empty())
        return said_if_equal(
            config, compare_pictures(config.model, config.cloud, "", config.threshold), context);
    Stamp stamp(context, manifest_path(config.output));
    stamp.input(config.model);
    stamp.input(config.cloud);
    stamp.outputs({config.output});
    if (auto done = stamp.up_to_date()) return said_if_equal(config, *done, context);
    const bool draws = is_picture(config.output);
    json result =
        compare_pictures(config.model, config.cloud, draws ? config.output : "", config.threshold);
    if (!draws) write_file_atomically(config.output, text_of(result, 2) + "\n");
    return said_if_equal(config, stamp.commit(std::move(result)), context);
}

}  // namespace

json run_measure(const MeasureConfig& config, StageContext& context) {
    const bool a = is_picture(config.model), b = is_picture(config.cloud);
    if (a != b)
        throw ConfigError(fmt::format("{}: a picture is compared with a picture; found {}",
                                      a ? config.model : config.cloud,
                                      a ? config.cloud : config.model));
    const Kind kind = a ? Kind::pictures : are_meshes(config) ? Kind::meshes : Kind::points;
    refuse_without_effect(config, kind);
    if (kind != Kind::pictures && is_picture(config.output))
        throw ConfigError(fmt::format("{}: only of two pictures a picture is made; expected a name of a JSON file",
                                      config.output));
    switch (kind) {
        case Kind::pictures:
            return measure_pictures(config, context);
        case Kind::meshes:
            return measure_meshes(config, context);
        default:
            return measure_points(config, context);
    }
}

}  // namespace slim
