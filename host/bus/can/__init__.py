"""Joints on CAN: adapters, the cycle of set-points and answers, their loads, parameters and faults."""
