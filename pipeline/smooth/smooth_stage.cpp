#include "pipeline/smooth/smooth_stage.h"

#include "formats/model_file.h"
#include "pipeline/input_kind.h"
#include "pipeline/json_text.h"
#include "pipeline/manifest.h"
#include "pipeline/measure/apart.h"
#include "pipeline/measure/mesh_input.h"
#include "pipeline/memory_size.h"
#include "pipeline/smooth/smooth_cloud.h"
#include "pipeline/smooth/smooth_faces.h"
#include "pipeline/smooth/smooth_refit.h"
#include "slim/base/error.h"
#include "slim/smooth/refit_budget.h"

#include <fmt/format.h>

#include <utility>

namespace slim {
namespace {

using nlohmann::json;

void check_paths(const SmoothConfig& config) {
    if (input_kind(config.cloud) == InputKind::model &&
        input_kind(config.model) == InputKind::cloud)
        throw ConfigError(fmt::format(
            "{0} is a cloud and {1} a model: expected the model first: slim smooth {1} {0} -o {2}",
            config.model, config.cloud, config.output));
    if (parse_memory_size(config.memory) < kLeastSmoothMemory)
        throw ConfigError({.key = "memory",
                           .expected = "at least " + memory_size_text(kLeastSmoothMemory),
                           .found = "'" + config.memory + "'"});
    require_model(config.model);
    refuse_to_overwrite(config.output, {config.model, config.cloud});
}

/// What the model's record says that it was fitted with; empty where it does not say.
json rules_of(const ModelFile& model) {
    const json provenance = json_or_discarded(model.provenance_json());
    const json rules =
        provenance.is_object() ? provenance.value("rules", json::object()) : json::object();
    return rules.is_object() ? rules : json::object();
}

SmoothModelRules smooth_rules(const ModelHeader& header, const json& rules) {
    return {.degree = header.degree,
            .choose_degree = rules.value("choose_degree", false),
            .mdl_threshold = header.mdl_threshold,
            .diagonal = header.diagonal,
            .noise_variance = header.noise_variance,
            .contrary_share = rules.value("contrary_share", 0.0),
            .spacing = rules.value("spacing", 0.0)};
}

json smoothed(const SmoothConfig& config, StageContext& context) {
    const ModelFile model = ModelFile::open(config.model);
    const SurfelTree tree = model.tree();
    const BallIndex index(tree);
    const bool has_faces = is_mesh(config.cloud);
    if (config.mode == "mesh" && !has_faces)
        throw DataError(config.cloud +
                        ": has no faces that name their corners; expected a mesh for "
                        "--mode mesh");
    const json rules = rules_of(model);
    const Smoother smoother{config,
                            context,
                            tree,
                            index,
                            model.header().origin,
                            model.header().diagonal,
                            rules.value("sharp", false) || !tree.sharp().empty(),
                            smooth_rules(model.header(), rules)};
    const bool as_mesh = has_faces && config.mode != "points";
    json result = as_mesh ? smooth_faces(smoother) : smooth_cloud(smoother);
    const bool lost = warn_of_lost(config.cloud, config.model, result.at("unsupported"),
                                   result.at("points"), context.reporter);
    if (!lost && !as_mesh && config.amount > 0)
        say_what_is_known(result, smoother.diagonal, config.model, config.cloud, context.reporter);
    return result;
}

}  // namespace

json run_smooth(const SmoothConfig& config, StageContext& context) {
    check_paths(config);
    Stamp stamp(context, manifest_path(config.output));
    stamp.input(config.model);
    stamp.input(config.cloud);
    stamp.outputs({config.output});
    if (auto done = stamp.up_to_date()) return *done;
    json result = smoothed(config, context);
    return stamp.commit(std::move(result));
}

}  // namespace slim
