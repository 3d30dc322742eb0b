"""The recurrence, its adjoint and its sensitivities, one sequence after another."""

import math

import numba
import numpy as np


@numba.njit(cache=True, nogil=True, error_model="numpy")
def rollout(weights, inputs, state, sizes, outputs, final, activations):
    """Run sequences; weights (B, P), inputs (B, N, C), state (B, S)."""
    hidden, n_inputs, input_lags, output_lags = sizes
    n_in = n_inputs * (input_lags - 1)
    n_f = n_inputs * input_lags + output_lags
    x = np.empty(n_f)
    for b in range(len(inputs)):
        w = weights[b]
        s = state[b].copy()
        for k in range(inputs.shape[1]):
            for c in range(n_inputs):
                x[c] = inputs[b, k, c]
            for i in range(len(s)):
                x[n_inputs + i] = s[i]
            y = w[hidden * (n_f + 2)]
            for j in range(hidden):
                z = w[hidden * n_f + j]
                for f in range(n_f):
                    z += w[j * n_f + f] * x[f]
                h = math.tanh(z)
                activations[b, k, j] = h
                y += w[hidden * (n_f + 1) + j] * h
            for i in range(n_in):
                s[i] = x[i]
            for m in range(output_lags - 1, 0, -1):
                s[n_in + m] = s[n_in + m - 1]
            s[n_in] = y
            outputs[b, k] = y
        final[b] = s


@numba.njit(cache=True, nogil=True, error_model="numpy")
def adjoint(weights, inputs, state, sizes, outputs, activations, d_outputs, d_final, dw, dx, ds):
    """Vector-Jacobian product of `rollout`; dw, dx, ds must be zero on entry."""
    hidden, n_inputs, input_lags, output_lags = sizes
    n_in = n_inputs * (input_lags - 1)
    n_f = n_inputs * input_lags + output_lags
    n = inputs.shape[1]
    x = np.empty(n_f)
    dfeature = np.empty(n_f)
    for b in range(len(inputs)):
        w = weights[b]
        s = d_final[b].copy()  # adjoint of the state after the sample
        for k in range(n - 1, -1, -1):
            features(inputs[b], outputs[b], state[b], k, sizes, x)
            lam = d_outputs[b, k] + s[n_in]
            dfeature[:] = 0.0
            dw[b, hidden * (n_f + 2)] += lam
            for j in range(hidden):
                h = activations[b, k, j]
                dw[b, hidden * (n_f + 1) + j] += lam * h
                d = lam * w[hidden * (n_f + 1) + j] * (1.0 - h * h)
                dw[b, hidden * n_f + j] += d
                for f in range(n_f):
                    dw[b, j * n_f + f] += d * x[f]
                    dfeature[f] += d * w[j * n_f + f]
            # the state after the sample was: inputs of this sample and older, outputs
            for i in range(n_in):
                dfeature[i] += s[i]
            for m in range(1, output_lags):
                dfeature[n_f - output_lags + m - 1] += s[n_in + m]
            for c in range(n_inputs):
                dx[b, k, c] += dfeature[c]
            for i in range(len(s)):
                s[i] = dfeature[n_inputs + i]
        ds[b] = s


@numba.njit(cache=True, nogil=True, error_model="numpy")
def features(inputs, outputs, state, k, sizes, x):
    """Collect the features of sample k."""
    _, n_inputs, input_lags, output_lags = sizes
    for lag in range(input_lags):
        for c in range(n_inputs):
            if k >= lag:
                x[lag * n_inputs + c] = inputs[k - lag, c]
            else:
                x[lag * n_inputs + c] = state[(lag - k - 1) * n_inputs + c]
    n_in = n_inputs * (input_lags - 1)
    for m in range(1, output_lags + 1):
        if k >= m:
            x[n_inputs * input_lags + m - 1] = outputs[k - m]
        else:
            x[n_inputs * input_lags + m - 1] = state[n_in + m - k - 1]


@numba.njit(cache=True, nogil=True, error_model="numpy")
def jacobian(weights, inputs, state, sizes, outputs, activations, closed, jac):
    """Sensitivities of outputs to weights; `outputs` is what was fed back."""
    hidden, n_inputs, input_lags, output_lags = sizes
    n_f = n_inputs * input_lags + output_lags
    n_p = hidden * (n_f + 2) + 1
    x = np.empty(n_f)
    for b in range(len(inputs)):
        w = weights[b]
        for k in range(inputs.shape[1]):
            features(inputs[b], outputs[b], state[b], k, sizes, x)
            row = jac[b, k]
            row[n_p - 1] = 1.0
            for j in range(hidden):
                h = activations[b, k, j]
                row[hidden * (n_f + 1) + j] = h
                d = w[hidden * (n_f + 1) + j] * (1.0 - h * h)
                row[hidden * n_f + j] = d
                for f in range(n_f):
                    row[j * n_f + f] = d * x[f]
            if closed:
                for m in range(1, min(output_lags, k) + 1):
                    a = 0.0
                    for j in range(hidden):
                        h = activations[b, k, j]
                        d = w[hidden * (n_f + 1) + j] * (1.0 - h * h)
                        a += d * w[j * n_f + n_f - output_lags + m - 1]
                    for p in range(n_p):
                        row[p] += a * jac[b, k - m, p]
