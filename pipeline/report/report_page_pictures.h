#pragma once

#include "pipeline/report/report_results.h"

#include <string>

namespace slim {

/// The pictures that an experiment shows as HTML figures, in themselves as data; empty without.
std::string pictures_html(const ExperimentResult& result);

}  // namespace slim
