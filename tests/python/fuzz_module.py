#!/usr/bin/env python3
"""Calls everything the Python module has with anything: random types, shapes, sizes and lifetimes, by hypothesis.

    PYTHONPATH=build/release/python tests/python/fuzz_module.py --seconds 4        # tests/python/test_fuzz.py
    scripts/fuzz_python                                                            # ten minutes

A call may raise what Python or the library raise; it may not crash, and not say what only C++ understands. The last calls before a crash
are in the file that --log names."""
import argparse
import faulthandler
import gc
import math
import os
import signal
import sys
import tempfile
import threading
import time
import warnings

import hypothesis
import numpy as np
from hypothesis import strategies as st

import holdfast as hf

NUMBERS = [0, 1, -1, 2, 3, 7, 63, 255, 1000, 2**31, -2**31, 2**63, 2**64, 0.0, -0.0, 0.1, 0.5, 1.5, 2.0, -3.0, 1e-300, 1e300,
           math.nan, math.inf, -math.inf, True, False]
TEXTS = ["", "A", "A0", "A1", "A2", "L0", "x3", "r1234:7", "irls", "nesterov", "gnc-irls", "huber:2", "cauchy:1:component", "drop",
         "tukey:4:one_sided", "dropped", "received", "two.g2o", "two.pyfg", "gone.txt", "\0", "ß∞", "x" * 1000, "newton", "chordal"]
FILE = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n"
RAISED = (hf.Error, TypeError, ValueError, KeyError, IndexError, AttributeError, OverflowError, MemoryError, ZeroDivisionError, LookupError,
          ImportError, OSError, ArithmeticError)
CPP = ("std::", "bad_cast", "nanobind", "_M_", "basic_string", "vector::")
LEFT_OUT = {"plot", "to_dataframe", "Template", "annotations"}  # plotly and pandas are not ours


def classes_and_functions():
    names = [name for name in dir(hf) if not name.startswith("_") and name not in LEFT_OUT]
    things = [getattr(hf, name) for name in names]
    return [one for one in things if callable(one) and not (isinstance(one, type) and issubclass(one, BaseException))]


THINGS = classes_and_functions()
FACTORS = [getattr(hf._core, name) for name in dir(hf._core) if hasattr(getattr(hf._core, name), "_add")]
VARIABLES = [hf.Point2, hf.Point3, hf.Pose2, hf.Pose3, hf.Motion2, hf.Motion3, hf.Accel2, hf.Accel3, hf.Turning2, hf.Scalar]


class Session:
    def __init__(self, random, log):
        self.random, self.log, self.pool, self.depth, self.calls, self.notes = random, log, [], 0, 0, 0

    def array(self):
        shape = [self.random.choice([0, 1, 2, 3, 4, 6, 7, 17]) for _ in range(self.random.choice([0, 1, 1, 1, 2, 2, 3]))]
        kind = self.random.choice(["float64", "float64", "float32", "int64", "uint64", "object", "complex128", "U3"])
        made = np.full(shape, self.random.choice([0, 1, 2, 5])).astype(kind)
        if kind == "float64" and made.size and self.random.random() < 0.2:
            made.flat[0] = self.random.choice([math.nan, math.inf, -1])
        if made.ndim == 2 and made.shape[0] == made.shape[1] and self.random.random() < 0.7:
            made = np.eye(len(made))
        return made[::-1] if made.ndim and self.random.random() < 0.2 else made

    def function(self):
        def called(*args, **named):
            self.depth += 1
            try:
                if self.depth < 3 and self.random.random() < 0.3:
                    self.call()
                for one in args:
                    if len(self.pool) < 60 and self.random.random() < 0.2:
                        self.pool.append(one)
                roll = self.random.random()
                if roll < 0.1:
                    raise self.random.choice([ValueError, KeyError, KeyboardInterrupt, StopIteration, SystemExit])("by the function")
                if roll < 0.6 and args and isinstance(args[-1], np.ndarray):
                    return args[-1][:, :1] * 0.5 if args[-1].ndim == 2 else args[-1][:1]
                return self.value()
            finally:
                self.depth -= 1
        return called

    def variable(self):
        kind = self.random.choice(VARIABLES)
        try:
            return kind().retract(np.array([self.random.choice([0, 0.1, 1, 5]) for _ in range(kind.dim)]))
        except RAISED:
            return kind()

    def factor(self):
        kind = self.random.choice(FACTORS)
        fields = {}
        for one in kind.fields.split(", "):
            name, type_ = one.split(" ", 1)
            if "[" not in type_:
                usual = [1, 1, 1, 0, 2, -1, 77] if "int" in type_ else [1.0, 1.0, 0.1, 0.0, -1.0, math.nan]
                fields[name] = self.random.choice(usual)
            elif "x" in type_:
                rows, columns = (int(n) for n in type_[7:-1].split("x"))
                fields[name] = np.eye(rows, columns)
            else:
                fields[name] = getattr(hf, type_.split("[")[0])()
        return kind(**fields)

    def value(self):
        random = self.random
        roll = random.random()
        if self.pool and roll < 0.45:
            return random.choice(self.pool)
        if roll < 0.55:
            return random.choice(NUMBERS)
        if roll < 0.65:
            return random.choice(TEXTS)
        if roll < 0.72:
            return self.array()
        if roll < 0.8:
            return self.variable()
        if roll < 0.87:
            return self.factor()
        if roll < 0.9:
            return self.function()
        if roll < 0.94:
            return [self.value() for _ in range(random.choice([0, 1, 2, 3]))]
        if roll < 0.96:
            return random.choice(THINGS + VARIABLES + FACTORS)
        return random.choice([None, b"", b"\0\1\2", (), {}, object(), hf.Key("A0"), hf.Agent("A"), hf.Loss("huber:2"), 1j, type, range(3)])

    def problem(self):
        """Now and then something that works: a graph and values of it."""
        graph, values, key = hf.Graph(), hf.Values(), hf.Agent("A")
        factor = self.factor()
        types = [getattr(hf, name) for name in type(factor).__name__.split("_")[1:]]
        keys = [key(i) for i in range(len(types))]
        for one, kind in zip(keys, types):
            values.insert(one, kind())
        self.pool += [graph, values, factor, *keys]
        self.pool.append(graph.add(factor, keys, loss=self.random.choice([None, "huber:2", hf.Cauchy(1)])))
        if self.random.random() < 0.3:
            graph.add_function(self.function(), types, [keys], self.random.choice([1, 2]), vectorized=self.random.random() < 0.5)
        self.pool.append(hf.make_backend(self.random.choice(["irls", "nesterov", "gnc-irls"]), max_iterations=20, time_limit=0.2))

    def window(self):
        white = hf.WhiteAcceleration[hf.Motion2].continuous(0.1, 1)
        window = hf.Window(lag=self.random.choice([0.3, 1, math.inf]), report=True, covariances=True,
                           on_leaving=self.random.choice([None, self.function()]))
        if self.random.random() < 0.7:
            window.add_agent("A", white, dt=0.1)
        else:
            window.add_agent("A", self.random.choice([self.function(), lambda *_: white]), of=type(white))
        window.add_state("A0", 0.0, hf.Motion2())
        window.add(hf.Prior[hf.Motion2].from_sigmas(hf.Motion2(), [1, 1, 1, 1]), ["A0"])
        window.add_beacon("L0", hf.Point2(3, 4))
        self.pool += [window, hf.Schedule(window), window.at("A", 0.1)]
        window.step(0.1)

    def note(self, text):
        self.notes += 1
        os.pwrite(self.log, f"{self.notes}: {text}\n".encode(errors="replace").ljust(2000), 2000 * (self.notes % 50))

    def call(self):
        random = self.random
        self.calls += 1
        roll = random.random()
        if roll < 0.04:
            return self.problem()
        if roll < 0.06:
            return self.window()
        if roll < 0.1:
            self.pool = random.sample(self.pool, len(self.pool) // 2)
            return gc.collect() if random.random() < 0.05 else None
        ours = [one for one in self.pool if type(one).__module__.startswith("holdfast")]
        target = random.choice(THINGS + FACTORS) if roll < 0.3 or not ours else random.choice(ours)
        name = ""
        if not (roll < 0.3 and callable(target)):
            name = random.choice([one for one in dir(target) if one not in ("__class__", "__reduce__", "__subclasshook__")])
            target_of = target
            self.note(f"{name} of {type(target)!r}")
            target = getattr(target, name)
            if not callable(target):
                return self.keep(target)
            if random.random() < 0.01 and not isinstance(target_of, type):
                return setattr(target_of, name, self.value())
        args = [self.value() for _ in range(random.choice([0, 1, 1, 2, 2, 3, 4, 5]))]
        self.note(f"{name} {target!r:.200} {args!r:.1500}")
        if random.random() < 0.03:
            thread = threading.Thread(target=lambda: self.guarded(lambda: target(*args)))
            thread.start()
            self.guarded(self.call)
            return thread.join()
        return self.keep(target(*args))

    def keep(self, result):
        if len(self.pool) > 80:
            self.pool.pop(self.random.randrange(len(self.pool)))
        if type(result).__module__.startswith("holdfast") or self.random.random() < 0.1:
            self.pool.append(result)

    def guarded(self, work):
        try:
            work()
        except RAISED as error:
            refuse_cpp(error)
        except (KeyboardInterrupt, StopIteration, SystemExit, RecursionError):
            pass
        except RuntimeError as error:  # of a Python function, with its name
            refuse_cpp(error)


def refuse_cpp(error):
    """What a user reads is of this library or of Python. nanobind's own TypeErrors list the signatures that there are."""
    text = str(error)
    if not isinstance(error, (TypeError, AttributeError)) and any(word in text for word in CPP):
        raise AssertionError(f"{type(error).__name__}: {text}") from error


def fuzz(seconds, log):
    ends = time.monotonic() + seconds
    calls = [0]

    def interrupt(*_):
        raise KeyboardInterrupt

    signal.signal(signal.SIGALRM, interrupt)
    here = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        with open("two.g2o", "w", encoding="utf-8") as file:
            file.write(FILE)

        @hypothesis.settings(max_examples=30, deadline=None, database=None, suppress_health_check=list(hypothesis.HealthCheck),
                             phases=[hypothesis.Phase.generate])
        @hypothesis.given(st.randoms(use_true_random=True))
        def one(random):
            if time.monotonic() > ends:
                return
            session = Session(random, log)
            for _ in range(300):
                signal.setitimer(signal.ITIMER_REAL, 5)
                faulthandler.dump_traceback_later(20, exit=True)  # a hang is a crash
                session.guarded(session.call)
            signal.setitimer(signal.ITIMER_REAL, 0)
            faulthandler.cancel_dump_traceback_later()
            calls[0] += session.calls

        while time.monotonic() < ends:
            try:
                one()
            except KeyboardInterrupt:
                pass
        os.chdir(here)
    return calls[0]


def main():
    warnings.simplefilter("ignore")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=600)
    parser.add_argument("--log", default=os.devnull)
    arguments = parser.parse_args()
    log = os.open(arguments.log, os.O_CREAT | os.O_RDWR, 0o644)
    print(f"{fuzz(arguments.seconds, log)} calls in {arguments.seconds:.0f} s, none crashed")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
