#pragma once

#include "slim/cover/level_cover.h"

#include <nlohmann/json.hpp>

#include <string>

namespace slim {

/// Whether edges got sharp surfels ("sharp"), where the points decided (--sharp auto) the share of
/// places at edges ("edge_share") and how many were looked at ("edge_places"), and of a part in
/// noise that its points were moved onto its faces ("on_faces").
nlohmann::json sharp_json(const CoverRules& rules, const Cover& cover);

/// The same keys of another result, and "sharp_by_faces" (is_sharp_by_faces).
nlohmann::json sharp_of(const nlohmann::json& result);

/// Whether a reader can change an option or a job's key.
enum class Remedies { of_a_command, of_a_job };

/// What the points decided and by which number, a line for people without its end; empty where an
/// option decided. result: with the keys of sharp_of
std::string edges_text(const nlohmann::json& result, Remedies remedies);

}  // namespace slim
