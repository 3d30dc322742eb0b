// narx.pt with libtorch. Reads rows "interval_s,sagittal,frontal,transverse" (s, rad/s; nan where
// lost) and writes the three angles (rad), their standard deviations (rad) and the quality.
// Any other row is an error.
#include <torch/script.h>

#include <cstdio>
#include <iostream>
#include <string>

int main(int argc, char **argv)
{
    if (argc != 2) {
        std::fprintf(stderr, "usage: %s narx.pt < samples.csv > angles.csv\n", argv[0]);
        return 2;
    }
    const c10::InferenceMode without_gradients;
    torch::jit::Module narx = torch::jit::load(argv[1]);
    torch::Tensor state = narx.get_method("start")({}).toTensor(); // an unknown start pose
    std::string line;
    for (long number = 1; std::getline(std::cin, line); number++) {
        double interval_s, rates[3];
        int end = 0;
        if (std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf %n", &interval_s, rates, rates + 1,
                        rates + 2, &end) != 4
            || line.c_str()[end]) {
            std::fprintf(stderr, "line %ld: expected four numbers, separated by commas\n", number);
            return 1;
        }
        const torch::Tensor sample = torch::tensor({rates[0], rates[1], rates[2]}, state.options());
        const torch::Tensor passed = torch::tensor(interval_s, state.options());
        const auto next = narx.get_method("step")({sample, state, passed}).toTuple();
        state = next->elements()[1].toTensor();
        const torch::Tensor std_rad = narx.get_method("standard_deviation")({state}).toTensor();
        for (const torch::Tensor &three : {next->elements()[0].toTensor(), std_rad})
            for (int axis = 0; axis < 3; axis++)
                std::printf("%.17g,", three[axis].item<double>());
        std::printf("%d\n", narx.get_method("quality")({state}).toTensor().item<int>());
    }
    return 0;
}
