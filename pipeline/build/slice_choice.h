#pragma once

#include "pipeline/build/plan_file.h"

#include <cstddef>
#include <vector>

namespace slim {

/// `slice` of a stage called inside another: all, whatever array job the whole build is part of.
inline constexpr int kAllSlices = -2;

/// Which slices of a work folder a call works on (CONVENTIONS 2.1).
struct SliceChoice {
    int slice = -1;
    int slices_per_task = 1;

    template <class Visitor>
    void visit(Visitor&& field) {
        field.part("slice", slice, "number of the slice; -1: the array job's index, else all", -1,
                   100000);
        field.part("slices_per_task", slices_per_task,
                   "of an array job: task i does this many slices, from slice i times this", 1,
                   500);
    }
};

/// `slice` if >= 0; -1: those of the task of an array job whose index is in SLURM_ARRAY_TASK_ID,
/// SGE_TASK_ID (which counts from 1) or PBS_ARRAY_INDEX, else all. throws ConfigError: no such
/// slice or task; an index that is no whole number, naming the variable; slices_per_task
///        beside a slice or without an array job, where it has no effect
std::vector<std::size_t> slices_to_do(const SliceChoice& choice, const SlicePlan& plan);

}  // namespace slim
