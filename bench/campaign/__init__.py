"""Looking for hard cases that nobody thought of: `python -m bench.campaign --minutes N --seed S`.

Random and adversarial designs, scenes and circuits, each judged by what must hold for every one of them
(invariants.py) in a process of its own, so that a crash, a hang and a thirst for memory are findings too.
"""
