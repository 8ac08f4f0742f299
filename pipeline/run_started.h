#pragma once

#include <string>

namespace slim {

/// Now in UTC, "2026-11-28T11:20:05Z".
std::string utc_now();

/// Whether a text is a time as utc_now() says it.
bool is_utc_time(const std::string& text);

/// When the run began that this process works for, as utc_now(): of `slim run`, `slim report` or
/// `slim render --job` for the steps that they have done, else of itself. What is no such time in
/// SLIM_RUN_STARTED is not taken.
const std::string& run_started();

/// Tells children which run they work for.
void hand_on_run_started();

}  // namespace slim
