#include "pipeline/run_started.h"

#include <cstdlib>
#include <ctime>

namespace slim {
namespace {

constexpr const char* kVariable = "SLIM_RUN_STARTED";

}  // namespace

std::string utc_now() {
    const std::time_t now = std::time(nullptr);
    std::tm parts{};
    gmtime_r(&now, &parts);
    char text[32];
    std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
    return text;
}

const std::string& run_started() {
    static const std::string started = [] {
        const char* said = std::getenv(kVariable);
        return said && *said ? std::string(said) : utc_now();
    }();
    return started;
}

void hand_on_run_started() { setenv(kVariable, run_started().c_str(), 1); }

}  // namespace slim
