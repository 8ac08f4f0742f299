#include "pipeline/run_started.h"

#include <cstdlib>
#include <ctime>

namespace slim {
namespace {

constexpr const char* kVariable = "SLIM_RUN_STARTED";

constexpr const char* kForm = "%Y-%m-%dT%H:%M:%SZ";

std::string in_our_form(const std::tm& utc) {
    char text[32];
    return {text, std::strftime(text, sizeof text, kForm, &utc)};
}

}  // namespace

std::string utc_now() {
    const std::time_t now = std::time(nullptr);
    std::tm parts{};
    gmtime_r(&now, &parts);
    return in_our_form(parts);
}

bool is_utc_time(const std::string& text) {
    std::tm parts{};
    const char* rest = strptime(text.c_str(), kForm, &parts);
    if (!rest || *rest) return false;
    const std::time_t seconds = timegm(&parts);  // a 31st of June becomes a 1st of July
    return seconds != -1 && gmtime_r(&seconds, &parts) && in_our_form(parts) == text;
}

const std::string& run_started() {
    static const std::string started = [] {
        const char* said = std::getenv(kVariable);
        return said && is_utc_time(said) ? std::string(said) : utc_now();
    }();
    return started;
}

void hand_on_run_started() { setenv(kVariable, run_started().c_str(), 1); }

}  // namespace slim
