#pragma once

#include "pipeline/build/fit_options.h"
#include "pipeline/build/plan_file.h"
#include "pipeline/build/slice_choice.h"
#include "pipeline/stage.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>
#include <string>

namespace slim {

/// Stage 3: surfels for every slice.
struct FitConfig : FitOptions, SliceChoice {
    std::string work;
    bool coarse = false;
    std::string memory = "1GiB";
    std::uint64_t seed = 0;

    template <class Visitor>
    void visit(Visitor&& field) {
        field.input("work", work, "work folder of `slim slice` and `slim normals`");
        SliceChoice::visit(field);
        field.part(
            "coarse", coarse,
            "only the coarse levels that all slices share: once before an array job over slices");
        FitOptions::visit(field);
        field("memory", memory,
              "bounds the sample that coarse levels of a job in slices are fitted from");
        field("seed", seed, "chooses among equally good centres");
    }
};

/// WORK/slice_0007/surfels.fit, and WORK/coarse.fit of a job of several slices.
std::filesystem::path fit_path(const std::filesystem::path& work, std::size_t slice);
std::filesystem::path coarse_fit_path(const std::filesystem::path& work);

/// throws ConfigError if options do not go together: the windows know neither prices nor edges,
///        coarse levels no slices
void check_fit_config(const FitConfig& config);

/// Writes surfels.fit of each slice. A job of several slices first fits its coarse levels once,
/// from a sample of all slices (coarse.fit); then slices are independent of each other: each reads
/// its own points and those of others in its halo (slice_points.h). With `coarse` it ends after
/// coarse.fit; a job of one slice has none.
/// throws DataError if there are fewer than 3 points or all coincide
nlohmann::json run_fit(const FitConfig& config, StageContext& context);

}  // namespace slim
