"""The run file: its content, and how it survives the kill of its writer.

A run file is one HDF5 file (readable from HDF5 1.10 on). Nothing in it is ever executed:

    about, versions, options        JSON texts
    scene/...                       the description (:mod:`lmgcpy.scene.description`), arrays and JSON texts
    frames/index                    one row a frame: time, step, first interaction, number of interactions
    frames/positions, velocities    (frames, n, 3): x, y, angle; in 3D x, y, z, and velocities with three more spins. If
                                    bodies keep a rotation in space, positions have a quaternion more, (frames, n, 7);
                                    spins are along the axes of space
    interactions                    interactions of all frames, one after the other
    history                         one row a step: solver and energy
    observed/...                    one row a step: values of the user's functions
    checkpoint/0, checkpoint/1      the state from which the run continues, written in turn
    commits                         two rows, written in turn: the number of valid rows of each table
    tails                           two rows, written in turn: sums of the valid rows in the last chunk of each table

HDF5's single-writer-multiple-reader mode keeps the structure valid at any time: the operating system has the writes of a
killed process in their order. Written rows count as soon as a later row of ``commits`` is complete, which its checksum
shows; the same holds for checkpoints. A power cut can still damage the file, because nothing is forced to the disk.
"""
