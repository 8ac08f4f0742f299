#pragma once

#include <string>

namespace slim {

/// Now in UTC, "2026-11-28T11:20:05Z".
std::string utc_now();

/// When the run began that this process works for, as utc_now(): of `slim run`, `slim report` or
/// `slim render --job` for the steps that they have done, else of itself.
const std::string& run_started();

/// Tells children which run they work for.
void hand_on_run_started();

}  // namespace slim
