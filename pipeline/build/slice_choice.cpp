#include "pipeline/build/slice_choice.h"

#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <numeric>
#include <optional>
#include <string>
#include <string_view>

namespace slim {
namespace {

/// The numbers from `begin` to before `end`.
std::vector<std::size_t> numbers(std::size_t begin, std::size_t end) {
    std::vector<std::size_t> out(end - begin);
    std::iota(out.begin(), out.end(), begin);
    return out;
}

/// The index of this task in its array job, from 0; none outside of one.
std::optional<long long> array_index() {
    struct Scheduler {
        const char* variable;
        long long first;
    };
    for (const auto& [variable, first] :
         {Scheduler{"SLURM_ARRAY_TASK_ID", 0}, Scheduler{"SGE_TASK_ID", 1},
          Scheduler{"PBS_ARRAY_INDEX", 0}}) {
        const char* value = std::getenv(variable);
        const std::string_view text = value ? value : "";
        if (text.empty() || text == "undefined")
            continue;  // as SGE says in jobs that are no arrays
        long long index = 0;
        const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), index);
        if (error != std::errc() || rest != text.data() + text.size() || index < first)
            throw ConfigError(fmt::format(
                "{}={}: expected the index of an array job's task, a whole number from {}",
                variable, text, first));
        return index - first;
    }
    return std::nullopt;
}

std::vector<std::size_t> slices_of_task(long long task, std::size_t per_task, std::size_t n) {
    const std::size_t tasks = (n + per_task - 1) / per_task;
    if (task >= static_cast<long long>(tasks))
        throw per_task == 1
            ? ConfigError({.key = "slice",
                           .problem = fmt::format(" {}: the plan has slices 0 to {}", task, n - 1)})
            : ConfigError(fmt::format("task {}: at {} slices a task the slices 0 to {} of the "
                                      "plan are those of tasks 0 to {}",
                                      task, per_task, n - 1, tasks - 1));
    const std::size_t begin = static_cast<std::size_t>(task) * per_task;
    return numbers(begin, std::min(begin + per_task, n));
}

}  // namespace

std::vector<std::size_t> slices_to_do(const SliceChoice& choice, const SlicePlan& plan) {
    const std::size_t n = plan.slices.size(),
                      per_task = static_cast<std::size_t>(choice.slices_per_task);
    if (choice.slice == kAllSlices) return numbers(0, n);
    if (choice.slice >= 0 && per_task > 1)
        throw ConfigError({.key = "slices_per_task",
                           .problem = "is for array jobs; --slice names one slice: leave out one "
                                      "of the two"});
    if (choice.slice >= 0) return slices_of_task(choice.slice, 1, n);
    if (const auto task = array_index()) return slices_of_task(*task, per_task, n);
    if (per_task > 1)
        throw ConfigError({.key = "slices_per_task",
                           .problem = "is for array jobs",
                           .found = "none of SLURM_ARRAY_TASK_ID, SGE_TASK_ID and PBS_ARRAY_INDEX "
                                    "in the environment"});
    return numbers(0, n);
}

}  // namespace slim
