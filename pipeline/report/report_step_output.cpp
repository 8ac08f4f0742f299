#include "pipeline/report/report_step_output.h"

#include "pipeline/json_text.h"
#include "pipeline/median.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <sstream>

namespace slim {

using nlohmann::json;

json object_in(const std::string& output) {
    json whole = json_or_discarded(output);
    if (whole.is_object()) return whole;
    std::istringstream in(output);
    json found = json::object();
    for (std::string line; std::getline(in, line);) {
        json object = json_or_discarded(line);
        if (object.is_object()) found = std::move(object);
    }
    return found;
}

void put_warnings(const std::string& log, json& figures) {
    std::ifstream in(log);
    std::uint64_t n = 0;
    std::string first;
    for (std::string line; std::getline(in, line);) {
        const std::size_t at = line.find("warning: ");
        if (at == std::string::npos) continue;
        if (n++ == 0) first = line.substr(at + 9);
    }
    figures["warnings"] = n;
    figures["warning"] = first;
}

void StepTimes::put(json& figures) const {
    figures["seconds"] = median(seconds);
    figures["seconds_min"] = *std::min_element(seconds.begin(), seconds.end());
    figures["seconds_max"] = *std::max_element(seconds.begin(), seconds.end());
    figures["processor_seconds"] = median(processor);
    figures["runs"] = seconds.size();
}

}  // namespace slim
