"""Window and Schedule as C++ has them: the type of a factor says which of the core's functions is meant."""
from . import _core


def install(key, loss, prior_of):
    """Gives Window what the core's templates are in C++. key, loss: texts to Keys and Losses; prior_of(variable): a prior on its type."""
    squared = _core.Loss("squared")

    def or_squared(given):
        return squared if given is None else loss(given)

    def add_agent(self, agent, motion, dt=None, of=None, loss=None):
        """How an agent moves: a motion factor of one step of dt [s], or motion(seconds, state), a function that returns a factor of the
        type `of` for any time; state is None where nothing is known of it."""
        if dt is not None:
            if not hasattr(motion, "_move_in_steps"):
                raise TypeError(f"{motion!r} is no motion of steps; give WhiteAcceleration or WhiteJerk, or a function without dt")
            motion._move_in_steps(self, agent, dt, or_squared(loss))
        elif not hasattr(of, "_move_by"):
            raise TypeError(f"of = {of!r} is no motion factor; name what the function returns, such as WhiteAcceleration[Motion2]")
        else:
            of._move_by(self, agent, motion, or_squared(loss))

    def add_state(self, state, time, start, odometry=None, loss=None):
        """A state with a start value; or, with odometry, the one that this factor on (start, state) leads to: `start` is then a key."""
        if odometry is None:
            self._add_state(state, time, start)
        elif not hasattr(odometry, "_lead"):
            raise TypeError(f"{odometry!r} leads to no state; give a Between, WhiteAcceleration or WhiteJerk")
        else:
            odometry._lead(self, state, time, start, or_squared(loss))

    def add_landmark(self, landmark, start):
        """A variable without a time: it stays until it is removed."""
        self._add_landmark(landmark, start)

    def add_beacon(self, beacon, known):
        """A landmark that is known: a constant."""
        self._add_beacon(beacon, known)

    def add(self, factor, keys, loss=None, weight=None):
        """A measurement, as Graph.add."""
        graph = _core.Graph()
        return self.add_from(graph, graph.add(factor, keys, loss, weight))

    def add_function(self, function, types, keys, residual_dim, **more):
        """Measurements by a Python function, as Graph.add_function."""
        graph = _core.Graph()
        return [self.add_from(graph, one) for one in graph.add_function(function, types, keys, residual_dim, **more)]

    def keep_lock(self, agent, state, nothing_known, memory=60, recent=8, rejected=3.5, patience=5, settled=10):
        """The agent notices that it follows outliers, and finds its way back. state: the type of its states; nothing_known(state):
        the Prior on it that says what is known before any measurement."""
        _core._keep_lock(self, agent, prior_of(state), nothing_known, memory, recent, rejected, patience, settled)

    window = _core.Window
    for one in (add_agent, add_state, add_landmark, add_beacon, add, add_function, keep_lock):
        setattr(window, one.__name__, one)
    return or_squared


class Schedule:
    """Which measurements of a Window were expected, and what became of each.

    stream = schedule.expect(hf.Range[hf.Motion2, hf.Point2], hf.Agent("A"), hf.Key("L0"), first=0, period=0.1)
    schedule.receive(stream, t, hf.Range[hf.Motion2, hf.Point2](12.3, 0.5), loss="huber:2")
    schedule.close(now)                                  # what has not come by now is dropped
    schedule.judge(window.step(now).report)              # what its loss does not believe is rejected
    """

    def __init__(self, window):
        self._window = window
        self._core = _core._Schedule(window)

    def expect(self, factor_type, a, b, first, period, missing=None):
        """A stream of measurements of this type, one each period [s] from first [s] on. missing(last, m): the MissingDistance that the
        m-th missing one after `last` says; without it, nothing."""
        if not hasattr(factor_type, "_expect"):
            raise TypeError(f"{factor_type!r} is no measurement between two variables that a schedule takes")
        if missing is None:
            return factor_type._expect(self._core, self._window, a, b, first, period)
        if not hasattr(factor_type, "_expect_or"):
            raise TypeError(f"{factor_type!r} says nothing where it is missing; only Range does (MissingDistance)")
        return factor_type._expect_or(self._core, self._window, a, b, first, period, missing)

    def receive(self, stream, time, factor, loss=None):
        if not hasattr(factor, "_receive"):
            raise TypeError(f"{factor!r} is no measurement that a schedule takes")
        factor._receive(self._core, self._window, stream, time, Schedule._or_squared(loss))

    def lose(self, stream, time, why):
        """Known to be missing: 'dropped', 'out_of_range' or 'rejected'."""
        self._core._lose(self._window, stream, time, why)

    def close(self, now):
        self._core._close(self._window, now)

    def judge(self, report):
        self._core.judge(report)

    def count(self, stream, arrival):
        return self._core.count(stream, arrival)

    def entries(self, stream):
        """[(number, arrival)] of those whose states may be in the window, oldest first."""
        return self._core.entries(stream)

    def save(self):
        return self._core.save()

    def restore(self, saved):
        self._core.restore(saved)
