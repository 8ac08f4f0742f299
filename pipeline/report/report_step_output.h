#pragma once

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace slim {

/// The JSON object that a program wrote: all of its output, or the last line that is one;
/// empty without.
nlohmann::json object_in(const std::string& output);

/// Warnings counted, and the first of them, from what a child wrote on stderr, into `figures`.
void put_warnings(const std::string& log, nlohmann::json& figures);

/// Seconds that the runs of a step took: on the clock, and of processors.
struct StepTimes {
    std::vector<double> seconds, processor;

    /// Medians, extremes of the clock's, and how many; of one run at least.
    void put(nlohmann::json& figures) const;
};

}  // namespace slim
